//! Maps in files: a header, then the lists as one compressed stream. `robots/README.md` tells the format.

use miniz_oxide::deflate::compress_to_vec_zlib;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

use super::about::{About, Fnv, MappedArm, ReachMethod};
use super::bytes::{Reader, add_name, bad};
use super::closed::ClosedForm;
use super::forward::chain_of;
use super::grid::{Grid, MOST_EDGE, MOST_VOXELS, VOXEL_M};
use super::map::Data;
use super::recipe::{Recipe, Samples};
use super::scale::Scale;
use super::spots::Spots;
use super::{Orientations, ReachError, ReachMap};
use crate::robot::Robot;

const MAGIC: &[u8; 8] = b"ECREACH\n";
const VERSION: u16 = 1;
/// Lattice coordinates of a grid's first voxel are no larger than this.
const FARTHEST: i32 = 1 << 20;
/// Most bytes of the lists.
const MOST_BYTES: usize = 1 << 27;
/// How hard to compress, 0 to 10.
const EFFORT: u8 = 9;

/// Everything before the lists.
struct Header {
    about: About,
    grid: Grid,
    orientations: usize,
    most: f64,
    poses: usize,
}

impl About {
    /// What a file is a map of, without reading the map.
    ///
    /// # Errors
    /// [`ReachError::BadFile`] when the file is none, or its header is damaged.
    pub fn of_file(bytes: &[u8]) -> Result<Self, ReachError> {
        Ok(Header::read(&mut Reader::new(bytes), bytes)?.about)
    }
}

impl Header {
    fn write(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        let arm = &self.about.arm;
        [&arm.robot, &arm.arm, &arm.base_link].into_iter().for_each(|name| add_name(&mut bytes, name));
        bytes.push(arm.joints);
        bytes.extend(arm.fingerprint.to_le_bytes());
        match self.about.method {
            ReachMethod::Inverse { torso_positions } => bytes.extend([0, torso_positions]),
            ReachMethod::Forward { samples, seed } => {
                bytes.push(1);
                bytes.extend(samples.to_le_bytes());
                bytes.extend(seed.to_le_bytes());
            }
        }
        bytes.extend(self.grid.voxel_m.to_le_bytes());
        self.grid.first.iter().for_each(|first| bytes.extend(first.to_le_bytes()));
        self.grid.size.iter().for_each(|size| bytes.extend((*size as u16).to_le_bytes()));
        bytes.extend((self.orientations as u16).to_le_bytes());
        bytes.extend(self.most.to_le_bytes());
        bytes.extend((self.poses as u32).to_le_bytes());
        bytes.extend(Fnv::of(&bytes).to_le_bytes());
        bytes
    }

    fn read(reader: &mut Reader<'_>, bytes: &[u8]) -> Result<Self, ReachError> {
        let magic = reader.take("magic", MAGIC.len())?;
        if magic != MAGIC {
            return bad("magic", magic.escape_ascii(), MAGIC.escape_ascii());
        }
        let version = reader.u16("version")?;
        if version != VERSION {
            return bad("version", version, VERSION);
        }
        let arm = MappedArm {
            robot: reader.name("name of the robot")?,
            arm: reader.name("name of the arm")?,
            base_link: reader.name("name of the base link")?,
            joints: reader.u8("joints")?,
            fingerprint: reader.u64("fingerprint")?,
        };
        let method = match reader.u8("method")? {
            0 => ReachMethod::Inverse { torso_positions: reader.u8("torso positions")? },
            1 => ReachMethod::Forward { samples: reader.u32("samples")?, seed: reader.u64("seed")? },
            other => return bad("method", other, "0 or 1"),
        };
        let voxel_m = reader.f64("voxel")?;
        let first = [reader.i32("first voxel")?, reader.i32("first voxel")?, reader.i32("first voxel")?];
        let size = [reader.u16("voxels")?, reader.u16("voxels")?, reader.u16("voxels")?].map(usize::from);
        let orientations = usize::from(reader.u16("orientations")?);
        let (most, poses) = (reader.f64("greatest manipulability")?, reader.u32("poses")? as usize);
        let sum = Fnv::of(&bytes[..reader.at()]);
        let told = reader.u64("checksum of the header")?;
        if told != sum {
            return bad("checksum of the header", format!("{told:016x}"), format!("{sum:016x}"));
        }
        if !VOXEL_M.contains(&voxel_m) {
            return bad("voxel", voxel_m, "0.005 to 0.5 m");
        }
        if let Some(far) = first.iter().find(|first| !(-FARTHEST..=FARTHEST).contains(first)) {
            return bad("first voxel", far, format!("at most {FARTHEST} from 0"));
        }
        let voxels = size.iter().product::<usize>();
        if size.iter().any(|edge| !(1..=MOST_EDGE).contains(edge)) || voxels > MOST_VOXELS {
            return bad("voxels", format!("{size:?}"), format!("1 to {MOST_EDGE} each, {MOST_VOXELS} in all"));
        }
        if !Orientations::COUNTS.contains(&orientations) {
            return bad("orientations", orientations, "1, 40 or 272");
        }
        if poses > voxels * orientations {
            return bad("poses", poses, format!("at most {}", voxels * orientations));
        }
        if !(most.is_finite() && most >= 0.0) {
            return bad("greatest manipulability", most, "a finite number, 0 or more");
        }
        Ok(Self { about: About { arm, method }, grid: Grid { voxel_m, first, size }, orientations, most, poses })
    }

    /// Bytes of the bits of one orientation.
    fn plane(&self) -> usize {
        self.grid.count().div_ceil(8)
    }

    /// Bytes of each pose besides its bit: manipulability and what its configuration is made from.
    fn per_pose(&self) -> usize {
        1 + code_bytes(self.about.method)
    }

    /// Bytes of the lists when `spots` voxels have a point of their own.
    fn length(&self, spots: usize) -> usize {
        self.orientations * self.plane() + spots + self.poses * self.per_pose()
    }
}

fn code_bytes(method: ReachMethod) -> usize {
    match method {
        ReachMethod::Inverse { torso_positions } => 1 + usize::from(torso_positions > 1),
        ReachMethod::Forward { .. } => 3,
    }
}

/// Whether each reached voxel has a byte for the point that stands for it.
fn has_spots(method: ReachMethod) -> bool {
    matches!(method, ReachMethod::Inverse { .. })
}

impl ReachMap {
    /// The map as a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let data = &*self.data;
        let header = Header {
            about: data.about.clone(),
            grid: data.grid.clone(),
            orientations: data.orientations.count(),
            most: data.scale.most,
            poses: data.codes.len(),
        };
        let mut body = vec![0; header.orientations * header.plane()];
        let mut order = Vec::with_capacity(data.codes.len());
        for (orientation, plane) in body.chunks_exact_mut(header.plane()).enumerate() {
            for voxel in 0..data.grid.count() {
                if let Some(index) = data.index(voxel, orientation) {
                    plane[voxel / 8] |= 1 << (voxel % 8);
                    order.push(index);
                }
            }
        }
        if has_spots(header.about.method) {
            body.extend(self.voxels().map(|voxel| data.spots[voxel.0 as usize]));
        }
        let mut last = 0;
        body.extend(order.iter().map(|&index| {
            let level = data.levels[index];
            level.wrapping_sub(std::mem::replace(&mut last, level))
        }));
        for byte in 0..code_bytes(header.about.method) {
            body.extend(order.iter().map(|&index| (data.codes[index] >> (8 * byte)) as u8));
        }
        let mut bytes = header.write();
        let lists = compress_to_vec_zlib(&body, EFFORT);
        bytes.extend(Fnv::of(&lists).to_le_bytes());
        bytes.extend(lists);
        bytes
    }

    /// A map from a file, for the arm that it is of; with the torso if the arm is one with it
    /// ([`Robot::with_torso`]).
    ///
    /// * `arm`: index into [`Robot::arms`].
    ///
    /// # Errors
    /// [`ReachError::BadFile`] when the file is none or damaged, [`ReachError::OtherArm`] when it is one of another arm,
    /// hand, or of other limits.
    pub fn from_bytes(bytes: &[u8], robot: &Robot, arm: usize) -> Result<Self, ReachError> {
        let mut reader = Reader::new(bytes);
        let header = Header::read(&mut reader, bytes)?;
        let wanted = About::arm(robot, arm)?;
        if header.about.arm != wanted {
            return Err(ReachError::OtherArm { found: header.about.arm.to_string(), wanted: wanted.to_string() });
        }
        let (recipe, codes_below) = recipe(&header, robot, arm)?;
        let most = header.length(header.grid.count());
        if most > MOST_BYTES {
            return bad("lists", format!("{most} bytes"), format!("at most {MOST_BYTES}"));
        }
        let told = reader.u64("checksum of the lists")?;
        let stream = &bytes[reader.at()..];
        let sum = Fnv::of(stream);
        if told != sum {
            return bad("checksum of the lists", format!("{told:016x}"), format!("{sum:016x}"));
        }
        let body = decompress_to_vec_zlib_with_limit(stream, most);
        let Ok(body) = body else { return bad("lists", "damaged or longer data", format!("{most} bytes at most")) };
        let orientations =
            Orientations::new(header.orientations).ok_or(ReachError::BadOrientations { found: header.orientations })?;
        Ok(Self::new(lists(header, &body, orientations, recipe, codes_below)?))
    }
}

/// How configurations are made for this arm, and what their codes are below.
fn recipe(header: &Header, robot: &Robot, arm: usize) -> Result<(Recipe, u32), ReachError> {
    match header.about.method {
        ReachMethod::Inverse { torso_positions } => {
            let closed = ClosedForm::of(robot, &robot.arms[arm])?;
            let positions = closed.stands.len();
            if usize::from(torso_positions) != positions {
                return bad("torso positions", torso_positions, positions);
            }
            Ok((Recipe::Closed(Box::new(closed)), (positions as u32) << 8))
        }
        ReachMethod::Forward { samples, seed } => {
            let chain = chain_of(robot, &robot.arms[arm])?;
            Ok((Recipe::Drawn(Samples::of(&chain, seed)), samples))
        }
    }
}

/// The lists of the body, each of the length that the bits before it ask for.
fn lists(
    header: Header,
    body: &[u8],
    orientations: Orientations,
    recipe: Recipe,
    codes_below: u32,
) -> Result<Data, ReachError> {
    let (voxels, words) = (header.grid.count(), header.orientations.div_ceil(64));
    let mut reader = Reader::new(body);
    let mut bits = vec![0_u64; words * voxels];
    // Where each pose of the file stands in the map: first its voxel and orientation.
    let mut order = Vec::with_capacity(header.poses);
    for orientation in 0..header.orientations {
        let plane = reader.take("bits", header.plane())?;
        for (place, byte) in plane.iter().enumerate() {
            let mut byte = *byte;
            while byte != 0 {
                let voxel = 8 * place + byte.trailing_zeros() as usize;
                byte &= byte - 1;
                if voxel >= voxels || order.len() == header.poses {
                    return bad("bits", format!("one for voxel {voxel}"), format!("{} of {voxels}", header.poses));
                }
                bits[voxel * words + orientation / 64] |= 1 << (orientation % 64);
                order.push((voxel, orientation));
            }
        }
    }
    if order.len() != header.poses {
        return bad("bits", format!("{} poses", order.len()), header.poses);
    }
    let (method, poses) = (header.about.method, header.poses);
    let mut data = Data {
        about: header.about,
        grid: header.grid,
        orientations,
        bits,
        words,
        first: Vec::new(),
        spots: vec![0; voxels],
        places: Spots::new(header.orientations),
        scale: Scale::up_to(header.most),
        levels: vec![0; poses],
        codes: vec![0; poses],
        means: Vec::new(),
        recipe,
    };
    data.number();
    if has_spots(method) {
        let reached: Vec<usize> = (0..voxels).filter(|&voxel| data.first[voxel + 1] > data.first[voxel]).collect();
        for (voxel, spot) in reached.iter().zip(reader.take("points", reached.len())?) {
            if usize::from(*spot) >= Spots::COUNT {
                return bad("points", spot, format!("less than {}", Spots::COUNT));
            }
            data.spots[*voxel] = *spot;
        }
    }
    let order: Vec<usize> =
        order.into_iter().filter_map(|(voxel, orientation)| data.index(voxel, orientation)).collect();
    let mut level = 0_u8;
    for (index, step) in order.iter().zip(reader.take("manipulabilities", poses)?) {
        level = level.wrapping_add(*step);
        data.levels[*index] = level;
    }
    for byte in 0..code_bytes(method) {
        for (index, value) in order.iter().zip(reader.take("configurations", poses)?) {
            data.codes[*index] |= u32::from(*value) << (8 * byte);
        }
    }
    if let Some(code) = data.codes.iter().find(|code| **code >= codes_below) {
        return bad("configurations", code, format!("less than {codes_below}"));
    }
    if reader.at() != body.len() {
        return bad("end of the lists", format!("{} more bytes", body.len() - reader.at()), "none");
    }
    data.average();
    Ok(data)
}
