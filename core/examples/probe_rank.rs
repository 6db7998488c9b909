use endcomfort_core::{job::*, library::Library, pipeline::Pipeline, scene::Scene, watch::Watch};
use std::sync::Arc;
use std::time::Instant;
#[allow(clippy::all)]
fn main() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for demo in ["mustard", "jar", "glass"] {
        let scene =
            Scene::parse(&std::fs::read_to_string(root.join(format!("objects/scenes/{demo}.json"))).unwrap()).unwrap();
        let lib = library();
        let mut pipeline = Pipeline::new(lib);
        let begin = Instant::now();
        let now = || begin.elapsed().as_secs_f64() * 1e3;
        let mut request = Request::new(scene);
        request.last = Stage::Plan;
        let watch = Watch::new(&|| false, &|_, _| {}, &now);
        pipeline.run(&request, &watch, &mut |update| {
            if let Update::Done { elapsed_ms, output, .. } = update {
                match *output {
                    Output::Grasps(g) => println!(
                        "{demo} grasps {} accepted {} {elapsed_ms:.1} ms",
                        g.grasps.len(),
                        g.grasps.iter().filter(|g| g.is_accepted()).count()
                    ),
                    Output::Rank(r) => println!("{demo} rank {} {elapsed_ms:.1} ms", r.accepted),
                    Output::Fit(_) => println!("{demo} fit {elapsed_ms:.1}"),
                    Output::Plan(p) => println!("{demo} plan {elapsed_ms:.1} tried {:?}", p.failed_grasps),
                    Output::Quality(q) => println!("{demo} quality {} {elapsed_ms:.1} ms", q.len()), _ => {}
                }
            }
        });
    }
}
fn library() -> Arc<Library> {
    Arc::new(Library::new(Box::new(|path: &str| {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
        std::fs::read(file).ok().map(|bytes| &*bytes.leak())
    })))
}
