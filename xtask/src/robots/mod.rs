//! `cargo xtask robots`: draws the links of our robots and writes them to `robots/meshes/`.
//!
//! One OBJ per link and material, in the frame of the link at q = 0, in metres. The shapes follow the link lengths and
//! stay within the collision shapes of the URDF files.

mod arm;
mod hands;
mod hubo;
mod human;
mod shapes;
mod surface;
mod torso;

use std::path::Path;

use anyhow::Context as _;

use surface::Surface;

/// Largest size of all meshes together, bytes: they travel with the page.
const TOTAL_BYTES: usize = 950_000;

/// One file: the part of a link that has one material.
struct Model {
    link: &'static str,
    material: &'static str,
    surface: Surface,
}

impl Model {
    fn new(link: &'static str, material: &'static str, surface: Surface) -> Self {
        Self { link, material, surface }
    }
}

fn models() -> Vec<Model> {
    [torso::models(), arm::models(), hands::models(), hubo::models(), human::models()].into_iter().flatten().collect()
}

/// Writes all meshes below the repository's root.
pub(crate) fn run(root: &Path) -> anyhow::Result<()> {
    let folder = root.join("robots/meshes");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let mut total = 0;
    for model in models() {
        let name = format!("{}_{}.obj", model.link, model.material);
        let text = model.surface.to_obj(&format!("{}, {}", model.link, model.material));
        total += text.len();
        println!("{name}: {} vertices, {} bytes", model.surface.points.len(), text.len());
        let path = folder.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    println!("{total} bytes together");
    anyhow::ensure!(total <= TOTAL_BYTES, "the meshes take {total} bytes, at most {TOTAL_BYTES} are meant to");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::surface::{cross, sub};
    use super::*;

    #[test]
    fn every_face_looks_outwards_as_its_normals_do() {
        for model in models() {
            let s = &model.surface;
            let (mut against, mut area) = (0.0, 0.0);
            for face in &s.faces {
                assert!(face.iter().all(|&i| i < s.points.len()));
                let doubled =
                    cross(sub(s.points[face[1]], s.points[face[0]]), sub(s.points[face[2]], s.points[face[0]]));
                let n =
                    face.iter().fold([0.0; 3], |sum: [f64; 3], &i| std::array::from_fn(|k| sum[k] + s.normals[i][k]));
                let along: f64 = (0..3).map(|k| doubled[k] * n[k]).sum();
                let size = doubled.iter().map(|x| x * x).sum::<f64>().sqrt();
                area += size;
                against += if along < 0.0 { size } else { 0.0 };
            }
            // Slivers at poles may turn over; a surface inside out would be all of it.
            assert!(against < 0.01 * area, "{} {}: {against} of {area}", model.link, model.material);
            assert!(s.points.iter().flatten().all(|x| x.is_finite()));
        }
    }
}
