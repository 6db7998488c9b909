//! Every format read back by a reader that is not its writer.

use std::io::Cursor;

use image::{Rgba, RgbaImage};

use super::clip::MAX_FRAMES;
use super::{AnimationError, AnimationFormat, Clip, Recorder};

const SIZE: [u32; 2] = [48, 32];

fn clip(format: AnimationFormat, fps: u32) -> Clip {
    Clip { format, fps, from_s: 0.5, to_s: 1.5 }
}

/// A white square that has gone 8 pixels per second to the right, on a ground that may be clear.
fn moment(time_s: f64, ground: [u8; 4]) -> RgbaImage {
    let left = (8.0 * time_s).round() as u32;
    RgbaImage::from_fn(SIZE[0], SIZE[1], |x, y| {
        let inside = (left..left + 6).contains(&x) && (10..16).contains(&y);
        Rgba(if inside { [250, 250, 250, 255] } else { ground })
    })
}

const BLUE: [u8; 4] = [20, 40, 120, 255];
const CLEAR: [u8; 4] = [0; 4];

fn record(clip: Clip, ground: [u8; 4]) -> Vec<u8> {
    let mut recorder = Recorder::new(clip, 2.0, SIZE, ground == CLEAR).expect("a part of the plan");
    while let Some(time_s) = recorder.wanted_s() {
        recorder.take(&moment(time_s, ground)).expect("a frame");
    }
    let (taken, wanted) = recorder.progress();
    assert_eq!(taken, wanted);
    recorder.finish().expect("a file")
}

#[test]
fn frames_stand_at_whole_steps_from_the_start_to_the_end() {
    let clip = clip(AnimationFormat::Apng, 30);
    assert_eq!((clip.frame_count(), clip.time_s(0), clip.time_s(30)), (31, 0.5, 1.5));
    // Three tenths are not a whole number of twelfths: the last frame comes before the end.
    let odd = Clip { to_s: 0.8, fps: 12, ..clip };
    assert_eq!(odd.frame_count(), 4);
    assert!((odd.time_s(3) - 0.75).abs() < 1e-12);
    let still = Clip { to_s: 0.5, ..clip };
    assert_eq!((still.frame_count(), still.check(2.0)), (1, Ok(())));
}

#[test]
fn what_is_no_part_of_the_plan_is_refused_with_numbers() {
    let good = clip(AnimationFormat::Gif, 25);
    let refused = |clip: Clip| clip.check(2.0).expect_err("no part of it");
    assert_eq!(
        refused(Clip { fps: 51, ..good }),
        AnimationError::Fps { found: 51, most: 50, format: AnimationFormat::Gif }
    );
    for (from_s, to_s) in [(-0.1, 1.0), (1.0, 0.5), (0.0, 2.5), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(matches!(refused(Clip { from_s, to_s, ..good }), AnimationError::Range { .. }), "{from_s} {to_s}");
    }
    let long = Clip { from_s: 0.0, to_s: 100.0, fps: 50, ..good };
    assert_eq!(long.check(100.0), Err(AnimationError::Frames { found: 5001 }));
    assert!(long.check(100.0).unwrap_err().to_string().contains(&MAX_FRAMES.to_string()));
}

#[test]
fn a_picture_of_another_size_and_a_missing_one_are_refused() {
    let mut recorder = Recorder::new(clip(AnimationFormat::Apng, 2), 2.0, SIZE, false).unwrap();
    let error = recorder.take(&RgbaImage::new(3, 3)).unwrap_err();
    assert_eq!(error, AnimationError::Size { frame: 0, found: [3, 3], wanted: SIZE });
    recorder.take(&moment(0.5, BLUE)).unwrap();
    assert!(recorder.finish().unwrap_err().to_string().contains("1.00 s is missing"));
}

#[test]
fn an_animated_png_has_every_pixel_of_every_frame() {
    for ground in [BLUE, CLEAR, [20, 40, 120, 99]] {
        let clip = clip(AnimationFormat::Apng, 10);
        let file = record(clip, ground);
        let mut decoder = png::Decoder::new(Cursor::new(&file));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let about = *reader.info().animation_control().expect("it is animated");
        assert_eq!((about.num_frames, about.num_plays), (11, 0));
        let mut canvas = RgbaImage::new(SIZE[0], SIZE[1]);
        for frame in 0..clip.frame_count() {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            let _info = reader.next_frame(&mut pixels).unwrap();
            let part = *reader.info().frame_control().expect("a frame");
            assert_eq!((part.delay_num, part.delay_den), (1, 10), "frame {frame}");
            for (index, pixel) in pixels.chunks_exact(4).take((part.width * part.height) as usize).enumerate() {
                let (x, y) = (index as u32 % part.width, index as u32 / part.width);
                let is_kept = part.blend_op == png::BlendOp::Over && pixel[3] == 0;
                if !is_kept {
                    canvas.put_pixel(part.x_offset + x, part.y_offset + y, Rgba(pixel.try_into().unwrap()));
                }
            }
            assert_eq!(canvas, moment(clip.time_s(frame), ground), "frame {frame}");
        }
    }
}

#[test]
fn a_gif_has_every_frame_and_lasts_as_long_as_the_clip() {
    for (ground, fps) in [(BLUE, 30), (CLEAR, 7)] {
        let clip = clip(AnimationFormat::Gif, fps);
        let file = record(clip, ground);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(Cursor::new(&file)).unwrap();
        assert_eq!([decoder.width(), decoder.height()].map(u32::from), SIZE);
        let mut canvas = RgbaImage::new(SIZE[0], SIZE[1]);
        let (mut frames, mut hundredths) = (0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            if ground == CLEAR {
                canvas = RgbaImage::new(SIZE[0], SIZE[1]);
            }
            for (index, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
                let (x, y) = (index as u32 % u32::from(frame.width), index as u32 / u32::from(frame.width));
                let at = (u32::from(frame.left) + x, u32::from(frame.top) + y);
                canvas.put_pixel(at.0, at.1, Rgba(pixel.try_into().unwrap()));
            }
            let wanted = moment(clip.time_s(frames), ground);
            for (found, wanted) in canvas.pixels().zip(wanted.pixels()) {
                let close = found.0.iter().zip(wanted.0).all(|(a, b)| a.abs_diff(b) <= 6);
                assert!(close, "frame {frames}: {found:?} for {wanted:?}");
            }
            hundredths += u32::from(frame.delay);
            frames += 1;
        }
        assert_eq!(frames, clip.frame_count());
        // As many frames as there are, each for 1 / fps seconds, to the nearest hundredth.
        assert_eq!(hundredths, (100 * frames as u32 + fps / 2) / fps);
    }
}

/// Names and contents, found from the end of the archive as its readers do, checksums and both headers compared.
fn unpacked(archive: &[u8]) -> Vec<(String, &[u8])> {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes(archive[at..at + 2].try_into().unwrap()));
    let u32_at = |at: usize| u32::from_le_bytes(archive[at..at + 4].try_into().unwrap()) as usize;
    let end = archive.len() - 22;
    assert_eq!((&archive[end..end + 4], u16_at(end + 8), u16_at(end + 20)), (&b"PK\x05\x06"[..], u16_at(end + 10), 0));
    let (mut at, count) = (u32_at(end + 16), u16_at(end + 10));
    assert_eq!(at + u32_at(end + 12), end, "the directory ends where its end begins");
    let mut files = Vec::new();
    for _ in 0..count {
        assert_eq!(&archive[at..at + 4], b"PK\x01\x02");
        let (size, name_length, local) = (u32_at(at + 24), u16_at(at + 28), u32_at(at + 42));
        let name = String::from_utf8(archive[at + 46..at + 46 + name_length].to_vec()).unwrap();
        assert_eq!(&archive[local..local + 4], b"PK\x03\x04");
        assert_eq!(archive[at + 6..at + 32], archive[local + 4..local + 30], "both headers say the same");
        let begin = local + 30 + name_length;
        assert_eq!(&archive[local + 30..begin], name.as_bytes());
        let content = &archive[begin..begin + size];
        assert_eq!(crc32fast::hash(content) as usize, u32_at(at + 16));
        files.push((name, content));
        at += 46 + name_length;
    }
    files
}

#[test]
fn the_archive_holds_one_png_for_every_frame() {
    let clip = clip(AnimationFormat::Frames, 4);
    let file = record(clip, CLEAR);
    let files = unpacked(&file);
    assert_eq!(files.len(), 5);
    for (frame, (name, bytes)) in files.into_iter().enumerate() {
        assert_eq!(name, format!("frame_{frame:04}.png"));
        let found = image::load_from_memory(bytes).unwrap().into_rgba8();
        assert_eq!(found, moment(clip.time_s(frame), CLEAR), "{name}");
    }
    assert_eq!(file, record(clip, CLEAR), "equal pictures give equal files");
}
