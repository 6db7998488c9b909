//! Properties of the cloud files: what is written is read back, and damaged files are refused, never panicked on.

#![allow(non_snake_case, reason = "frame letters: X_FC is the pose of C in F")]
#![allow(clippy::unwrap_used, reason = "a test may stop at what is missing")]

use endcomfort_core::cloud::{
    CloudError, PcdEncoding, PixelGrid, PlyEncoding, PointCloud, read_cloud, write_pcd, write_ply,
};
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;

const PCD: [PcdEncoding; 3] = [PcdEncoding::Ascii, PcdEncoding::Binary, PcdEncoding::BinaryCompressed];
const PLY: [PlyEncoding; 3] = [PlyEncoding::Ascii, PlyEncoding::LittleEndian, PlyEncoding::BigEndian];

/// Clouds whose coordinates survive 32-bit floats, half of them flat and repetitive so that they compress.
fn clouds() -> impl Strategy<Value = PointCloud> {
    let coordinate = prop_oneof![(-2.0f32..2.0).prop_map(f64::from), Just(0.5)];
    let point = prop::array::uniform3(coordinate).prop_map(Point3::from);
    (prop::collection::vec((point, any::<[u8; 3]>()), 1..300), any::<bool>(), prop::option::of(2u32..20)).prop_map(
        |(points, colored, width)| {
            let count = points.len() as u32;
            PointCloud {
                colors: if colored { points.iter().map(|(_, color)| *color).collect() } else { Vec::new() },
                points: points.into_iter().map(|(point, _)| point).collect(),
                // Every other pixel is a hole.
                grid: width.map(|width| PixelGrid {
                    width,
                    height: (2 * count).div_ceil(width).max(2),
                    pixels: (0..count).map(|k| 2 * k).collect(),
                }),
                X_FC: None,
            }
        },
    )
}

fn same(read: &PointCloud, written: &PointCloud) -> Result<(), TestCaseError> {
    prop_assert_eq!(&read.points, &written.points);
    prop_assert_eq!(&read.colors, &written.colors);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pcd_files_are_read_as_they_were_written(cloud in clouds()) {
        for encoding in PCD {
            let read = read_cloud("cloud.pcd", &write_pcd(&cloud, encoding)).unwrap();
            same(&read.value, &cloud)?;
            prop_assert_eq!(&read.value.grid, &cloud.grid);
            prop_assert_eq!(read.value.X_FC, None);
        }
    }

    #[test]
    fn ply_files_are_read_as_they_were_written(cloud in clouds()) {
        for encoding in PLY {
            let read = read_cloud("cloud", &write_ply(&cloud, encoding)).unwrap();
            same(&read.value, &cloud)?;
            prop_assert!(read.notes.is_empty());
        }
    }

    #[test]
    fn the_sensor_pose_survives(cloud in clouds(), angles in prop::array::uniform3(-3.0f64..3.0)) {
        // Far enough behind that every point lies in front.
        let turned = Isometry3::new(Vector3::zeros(), Vector3::from(angles));
        let X_FC = turned * Isometry3::translation(0.0, 0.0, -9.0);
        let cloud = PointCloud { X_FC: Some(X_FC), grid: None, ..cloud };
        for encoding in PCD {
            let read = read_cloud("cloud.pcd", &write_pcd(&cloud, encoding)).unwrap().value;
            let found = read.X_FC.unwrap();
            prop_assert!((found.translation.vector - X_FC.translation.vector).norm() < 1e-9);
            prop_assert!(found.rotation.angle_to(&X_FC.rotation) < 1e-6);
        }
    }

    #[test]
    fn a_file_that_was_cut_short_is_refused_or_read_without_its_end(cloud in clouds(), part in 0.0f64..1.0) {
        for (name, file) in files(&cloud) {
            let cut = &file[..(file.len() as f64 * part) as usize];
            if let Ok(read) = read_cloud(name, cut) {
                // Text may lose the end of its last number without anybody noticing.
                prop_assert!(read.value.points.len() <= cloud.points.len());
            }
        }
        for encoding in PCD {
            let file = write_pcd(&cloud, encoding);
            let start = file.windows(5).position(|word| word == b"DATA ").unwrap() + 24;
            let cut = start + ((file.len().saturating_sub(start + 8)) as f64 * part) as usize;
            if cut + 8 < file.len() && encoding != PcdEncoding::Ascii {
                let refusal = read_cloud("cloud.pcd", &file[..cut]).unwrap_err();
                prop_assert!(matches!(refusal, CloudError::TruncatedBinary { .. }), "{refusal}");
            }
        }
    }

    #[test]
    fn damaged_files_never_panic(
        cloud in clouds(),
        hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        in_header in any::<bool>(),
    ) {
        for (name, mut file) in files(&cloud) {
            let reach = if in_header { file.len().min(260) } else { file.len() };
            for (place, byte) in &hits {
                file[place.index(reach)] = *byte;
            }
            if let Ok(read) = read_cloud(name, &file) {
                check(&read.value);
            }
        }
    }

    #[test]
    fn headers_with_other_numbers_never_panic(
        cloud in clouds(),
        numbers in prop::collection::vec(prop_oneof![
            Just(String::from("18446744073709551615")), Just(String::from("4294967296")), Just(String::from("20000000")),
            Just(String::from("-1")), Just(String::from("0")), Just(String::from("nan")), Just(String::from("1e999")),
            (0u32..70_000).prop_map(|n| n.to_string()),
        ], 4),
        which in prop::collection::vec(any::<prop::sample::Index>(), 4),
    ) {
        for (name, file) in files(&cloud) {
            let end = (file.windows(11).position(|word| word == b"end_header\n").map(|at| at + 11))
                .or_else(|| file.windows(5).position(|word| word == b"DATA "))
                .unwrap_or(file.len());
            let header = String::from_utf8_lossy(&file[..end]).into_owned();
            let mut words: Vec<String> = header.split(' ').map(str::to_owned).collect();
            for (number, place) in numbers.iter().zip(&which) {
                let k = place.index(words.len());
                let line_end = words[k].find('\n').map(|at| words[k][at..].to_owned()).unwrap_or_default();
                words[k] = format!("{number}{line_end}");
            }
            let mut changed = words.join(" ").into_bytes();
            changed.extend_from_slice(&file[end..]);
            if let Ok(read) = read_cloud(name, &changed) {
                check(&read.value);
            }
        }
    }

    #[test]
    fn garbage_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..300), kind in 0usize..4) {
        let name = ["a.pcd", "a.ply", "a.xyz", "a"][kind];
        let _ = read_cloud(name, &bytes);
        let pcd = [b"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 9\nDATA binary_compressed\n", &bytes[..]].concat();
        let _ = read_cloud(name, &pcd);
    }
}

fn files(cloud: &PointCloud) -> Vec<(&'static str, Vec<u8>)> {
    let pcd = PCD.iter().map(|encoding| ("cloud.pcd", write_pcd(cloud, *encoding)));
    let ply = PLY.iter().map(|encoding| ("cloud.ply", write_ply(cloud, *encoding)));
    let lines = cloud.points.iter().map(|p| format!("{},{},{}\n", p.x, p.y, p.z));
    pcd.chain(ply).chain([("cloud.xyz", lines.collect::<String>().into_bytes())]).collect()
}

/// What every cloud that was read promises.
fn check(cloud: &PointCloud) {
    assert!(!cloud.points.is_empty());
    assert!(cloud.points.iter().all(|p| p.iter().all(|x| x.is_finite())));
    assert!(cloud.colors.is_empty() || cloud.colors.len() == cloud.points.len());
    if let Some(grid) = &cloud.grid {
        assert_eq!(grid.pixels.len(), cloud.points.len());
        assert!(grid.pixels.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(grid.pixels.iter().all(|pixel| *pixel < grid.width * grid.height));
    }
}
