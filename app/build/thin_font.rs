//! A variable font without what the interface never shows: other scripts, slanted letters, and light ones.
//!
//! Glyphs keep their numbers, so shaping and kerning stay as they are; those that are dropped lose their outlines and
//! their characters (OpenType 1.9.1, chapters "cmap", "glyf", "gvar", "post").

use std::collections::BTreeSet;

use read_fonts::collections::IntSet;
use read_fonts::tables::glyf::Glyph;
use read_fonts::tables::variations::TupleIndex;
use read_fonts::types::{GlyphId, Tag};
use read_fonts::{FontRef, TableProvider as _};

/// Characters that names, numbers and formulas are made of: Latin, Greek, Cyrillic, punctuation, super- and subscripts,
/// currencies, letter-like signs, arrows, mathematics, simple shapes.
const SHOWN: [(u32, u32); 10] = [
    (0x20, 0x24f),
    (0x300, 0x36f),
    (0x370, 0x3ff),
    (0x400, 0x45f),
    (0x1e60, 0x1e61),
    (0x2000, 0x20bf),
    (0x2100, 0x214f),
    (0x2190, 0x21ff),
    (0x2200, 0x22ff),
    (0x25a0, 0x25ff),
];
/// The axis of which nothing is used, and the one of which only what is heavier than regular is.
const AXES: [Tag; 2] = [Tag::new(b"slnt"), Tag::new(b"wght")];
/// What a shaper applies without being asked, and the figures of equal width.
const FEATURES: [&[u8; 4]; 8] = [b"ccmp", b"locl", b"rlig", b"rclt", b"calt", b"clig", b"liga", b"tnum"];
/// Length of a `post` table without names (version 3).
const POST_BYTES: usize = 32;

/// The thinned font; `None` if a table is missing or makes no sense.
pub(crate) fn thin(bytes: &[u8]) -> Option<Vec<u8>> {
    let font = FontRef::new(bytes).ok()?;
    let characters = characters(&font)?;
    let kept = kept_glyphs(&font, &characters)?;
    let (glyf, loca) = outlines(&font, &kept)?;
    let mut tables: Vec<(Tag, Vec<u8>)> = Vec::new();
    for record in font.table_directory().table_records() {
        let tag = record.tag();
        let whole = || font.table_data(tag).map(|data| data.as_bytes().to_vec());
        let table = match &tag.to_be_bytes() {
            b"glyf" => glyf.clone(),
            b"loca" => loca.clone(),
            b"gvar" => variations(&font, &kept)?,
            b"cmap" => character_map(&characters),
            b"post" => nameless_post(&whole()?)?,
            b"head" => with_long_loca(whole()?)?,
            _ => whole()?,
        };
        tables.push((tag, table));
    }
    Some(assembled(tables))
}

/// The shown characters with their glyphs, in order.
fn characters(font: &FontRef<'_>) -> Option<Vec<(u32, GlyphId)>> {
    let cmap = font.cmap().ok()?;
    let code_points = SHOWN.iter().flat_map(|&(first, last)| first..=last);
    Some(code_points.filter_map(|code| Some((code, cmap.map_codepoint(code)?))).collect())
}

/// The glyphs of those characters, what substitutions make of them, and the parts that they are composed of.
fn kept_glyphs(font: &FontRef<'_>, characters: &[(u32, GlyphId)]) -> Option<BTreeSet<u32>> {
    let mut glyphs: IntSet<GlyphId> = characters.iter().map(|(_, glyph)| *glyph).collect();
    glyphs.insert(GlyphId::new(0));
    let gsub = font.gsub().ok()?;
    let mut lookups = IntSet::empty();
    let features = gsub.feature_list().ok()?;
    for record in features.feature_records() {
        if FEATURES.iter().any(|tag| record.feature_tag() == Tag::new(tag)) {
            let feature = record.feature(features.offset_data()).ok()?;
            lookups.extend(feature.lookup_list_indices().iter().map(|index| index.get()));
        }
    }
    gsub.closure_lookups(&glyphs, &mut lookups).ok()?;
    gsub.closure_glyphs(&lookups, &mut glyphs).ok()?;
    let (loca, glyf) = (font.loca(None).ok()?, font.glyf().ok()?);
    let mut kept = BTreeSet::new();
    let mut open: Vec<GlyphId> = glyphs.iter().collect();
    while let Some(glyph) = open.pop() {
        if kept.insert(glyph.to_u32())
            && let Some(Glyph::Composite(composite)) = loca.get_glyf(glyph, &glyf).ok()?
        {
            open.extend(composite.components().map(|part| GlyphId::from(part.glyph)));
        }
    }
    Some(kept)
}

/// `glyf` and `loca` (offsets of four bytes) with the outlines of the kept glyphs alone.
fn outlines(font: &FontRef<'_>, kept: &BTreeSet<u32>) -> Option<(Vec<u8>, Vec<u8>)> {
    let loca = font.loca(None).ok()?;
    let data = font.table_data(Tag::new(b"glyf"))?.as_bytes();
    let (mut glyf, mut offsets) = (Vec::new(), Vec::new());
    for glyph in 0..loca.len() {
        offsets.extend(u32::try_from(glyf.len()).ok()?.to_be_bytes());
        if kept.contains(&u32::try_from(glyph).ok()?) {
            let ends = [loca.get_raw(glyph)? as usize, loca.get_raw(glyph + 1)? as usize];
            glyf.extend(data.get(ends[0]..ends[1])?);
            glyf.resize(glyf.len().next_multiple_of(4), 0);
        }
    }
    offsets.extend(u32::try_from(glyf.len()).ok()?.to_be_bytes());
    Some((glyf, offsets))
}

/// `gvar` with the variations of the kept glyphs along the kept axes.
fn variations(font: &FontRef<'_>, kept: &BTreeSet<u32>) -> Option<Vec<u8>> {
    let gvar = font.gvar().ok()?;
    let fvar = font.fvar().ok()?.axes().ok()?;
    let [slant, weight] = AXES.map(|tag| fvar.iter().position(|axis| axis.axis_tag() == tag));
    let (slant, weight) = (slant?, weight?);
    let is_used = |peak: &[u8]| Some(word(peak, 2 * slant)? == 0 && word(peak, 2 * weight)? as i16 >= 0);
    let data = font.table_data(Tag::new(b"gvar"))?.as_bytes();
    let axes = usize::from(gvar.axis_count());
    let shared_at = gvar.shared_tuples_offset().to_u32() as usize;
    let shared = data.get(shared_at..shared_at + 2 * axes * usize::from(gvar.shared_tuple_count()))?;
    let glyphs = gvar.glyph_count();
    let (mut offsets, mut body) = (Vec::new(), Vec::new());
    for glyph in 0..glyphs {
        offsets.extend(u32::try_from(body.len()).ok()?.to_be_bytes());
        if !kept.contains(&u32::from(glyph)) {
            continue;
        }
        if let Some(glyph) = gvar.data_for_gid(GlyphId::new(u32::from(glyph))).ok()? {
            body.extend(used_only(glyph.as_bytes(), shared, axes, &is_used)?);
            body.resize(body.len().next_multiple_of(4), 0);
        }
    }
    offsets.extend(u32::try_from(body.len()).ok()?.to_be_bytes());
    let shared_at = 20 + offsets.len();
    let mut table = Vec::new();
    table.extend([0, 1, 0, 0]);
    table.extend(gvar.axis_count().to_be_bytes());
    table.extend(gvar.shared_tuple_count().to_be_bytes());
    table.extend(u32::try_from(shared_at).ok()?.to_be_bytes());
    table.extend(glyphs.to_be_bytes());
    // Offsets have four bytes.
    table.extend(1_u16.to_be_bytes());
    table.extend(u32::try_from(shared_at + shared.len()).ok()?.to_be_bytes());
    table.extend(offsets);
    table.extend(shared);
    table.extend(body);
    Some(table)
}

/// The variations of one glyph whose peaks are used.
///
/// * `shared`: the font's shared peaks, two bytes an axis, and so is what `is_used` is asked about.
fn used_only(glyph: &[u8], shared: &[u8], axes: usize, is_used: &dyn Fn(&[u8]) -> Option<bool>) -> Option<Vec<u8>> {
    let flags = word(glyph, 0)?;
    let (count, data_at) = (usize::from(flags & 0x0fff), usize::from(word(glyph, 2)?));
    let has_shared_points = flags & 0x8000 != 0;
    let points = if has_shared_points { packed_points(glyph.get(data_at..)?)? } else { 0 };
    let (mut header_at, mut part_at) = (4, data_at + points);
    let (mut headers, mut parts, mut left) = (Vec::<u8>::new(), glyph.get(data_at..part_at)?.to_vec(), 0_u16);
    for _ in 0..count {
        let size = usize::from(word(glyph, header_at)?);
        let index = TupleIndex::from_bits(word(glyph, header_at + 2)?);
        let peak = if index.embedded_peak_tuple() {
            glyph.get(header_at + 4..header_at + 4 + 2 * axes)?
        } else {
            let at = 2 * axes * usize::from(index.tuple_records_index()?);
            shared.get(at..at + 2 * axes)?
        };
        let tuples = usize::from(index.embedded_peak_tuple()) + 2 * usize::from(index.intermediate_region());
        let header = 4 + 2 * axes * tuples;
        if is_used(peak)? {
            headers.extend(glyph.get(header_at..header_at + header)?);
            parts.extend(glyph.get(part_at..part_at + size)?);
            left += 1;
        }
        header_at += header;
        part_at += size;
    }
    if left == 0 {
        return Some(Vec::new());
    }
    let mut thinned = Vec::new();
    thinned.extend((flags & 0xf000 | left).to_be_bytes());
    thinned.extend(u16::try_from(4 + headers.len()).ok()?.to_be_bytes());
    thinned.extend(headers);
    thinned.extend(parts);
    Some(thinned)
}

/// Length of a list of packed point numbers, bytes.
fn packed_points(bytes: &[u8]) -> Option<usize> {
    let first = *bytes.first()?;
    let (count, mut at) = match first & 0x80 {
        0 => (usize::from(first), 1),
        _ => (usize::from(word(bytes, 0)? & 0x7fff), 2),
    };
    let mut seen = 0;
    while seen < count {
        let control = *bytes.get(at)?;
        let run = usize::from(control & 0x7f) + 1;
        at += 1 + run * if control & 0x80 == 0 { 1 } else { 2 };
        seen += run;
    }
    Some(at)
}

/// `cmap` with one subtable of format 12 for Unicode.
fn character_map(characters: &[(u32, GlyphId)]) -> Vec<u8> {
    let mut groups: Vec<[u32; 3]> = Vec::new();
    for &(code, glyph) in characters {
        match groups.last_mut() {
            Some([first, last, start]) if code == *last + 1 && glyph.to_u32() == *start + code - *first => *last = code,
            _ => groups.push([code, code, glyph.to_u32()]),
        }
    }
    let count = groups.len() as u32;
    let mut table = Vec::new();
    // One subtable, of platform 3 (Windows), encoding 10 (full Unicode), 12 bytes from the start.
    [0_u16, 1, 3, 10].iter().for_each(|value| table.extend(value.to_be_bytes()));
    table.extend(12_u32.to_be_bytes());
    [12_u16, 0].iter().for_each(|value| table.extend(value.to_be_bytes()));
    [16 + 12 * count, 0, count].iter().for_each(|value| table.extend(value.to_be_bytes()));
    groups.iter().flatten().for_each(|value| table.extend(value.to_be_bytes()));
    table
}

/// `post` without the names of glyphs.
fn nameless_post(post: &[u8]) -> Option<Vec<u8>> {
    let mut table = post.get(..POST_BYTES)?.to_vec();
    table[..4].copy_from_slice(&[0, 3, 0, 0]);
    Some(table)
}

/// `head` that says that offsets in `loca` have four bytes.
fn with_long_loca(mut head: Vec<u8>) -> Option<Vec<u8>> {
    head.get_mut(50..52)?.copy_from_slice(&[0, 1]);
    Some(head)
}

/// A font file of these tables, in their order.
fn assembled(tables: Vec<(Tag, Vec<u8>)>) -> Vec<u8> {
    let count = tables.len() as u16;
    let log2 = count.ilog2() as u16;
    let mut file = vec![0, 1, 0, 0];
    [count, 16 << log2, log2, 16 * count - (16 << log2)].iter().for_each(|value| file.extend(value.to_be_bytes()));
    let mut at = 12 + 16 * tables.len();
    for (tag, table) in &tables {
        file.extend(tag.to_be_bytes());
        [checksum(table), at as u32, table.len() as u32].iter().for_each(|value| file.extend(value.to_be_bytes()));
        at += table.len().next_multiple_of(4);
    }
    for (_, table) in tables {
        file.extend(table);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    file
}

fn checksum(table: &[u8]) -> u32 {
    let word =
        |chunk: &[u8]| chunk.iter().fold(0_u32, |sum, byte| sum << 8 | u32::from(*byte)) << (8 * (4 - chunk.len()));
    table.chunks(4).map(word).fold(0, u32::wrapping_add)
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}
