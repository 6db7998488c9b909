//! The native window.

use std::sync::Arc;

use eframe::egui;
use endcomfort_core::job::{Request, Update};

use crate::assets;
use crate::host::{Fetched, Host};
use crate::jobs::Worker;
use crate::studio::BuiltInStudio;
use crate::viewer::{App, StartOptions};

/// Opens the window as it is asked for and returns when it is closed.
///
/// # Errors
/// A sentence saying why there is no window.
pub fn open(start: StartOptions) -> Result<(), String> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_title("Endcomfort").with_inner_size([1440.0, 900.0]),
        ..eframe::NativeOptions::default()
    };
    eframe::run_native(
        "endcomfort",
        options,
        Box::new(move |creation| {
            let host = WindowHost::new(creation)?;
            let app = App::new(creation, Box::new(host), Box::new(BuiltInStudio::default()), start)?;
            Ok(Box::new(app))
        }),
    )
    .map_err(|error| format!("the window could not be opened: {error}"))
}

/// A window, its worker thread, and files in the working folder.
struct WindowHost {
    worker: Worker,
    backend: String,
}

impl WindowHost {
    fn new(creation: &eframe::CreationContext<'_>) -> Result<Self, String> {
        let context = creation.egui_ctx.clone();
        let worker = Worker::start(move || context.request_repaint())
            .map_err(|error| format!("the system gives no thread for the computation: {error}"))?;
        let backend = creation
            .wgpu_render_state
            .as_ref()
            .map_or_else(|| "none".to_owned(), |gpu| format!("{:?}", gpu.adapter.get_info().backend));
        Ok(Self { worker, backend })
    }
}

impl Host for WindowHost {
    fn submit(&mut self, request: Request) {
        self.worker.submit(request);
    }

    fn cancel(&mut self) {
        self.worker.cancel();
    }

    fn poll(&mut self) -> Vec<Update> {
        self.worker.poll()
    }

    fn fetch(&mut self, path: &str, done: Fetched) {
        let file = assets::read(&format!("robots/{path}"));
        done(file.map(<[u8]>::to_vec).ok_or_else(|| "there is no such file".to_owned()));
    }

    fn save(&mut self, name: &str, bytes: &[u8]) -> String {
        let path = free_name(name);
        match std::fs::write(&path, bytes) {
            Ok(()) => format!("Saved {}", path.display()),
            Err(error) => format!("{} could not be written: {error}", path.display()),
        }
    }

    fn announce(&mut self, sentence: &str) {
        log::info!("{sentence}");
    }

    fn backend(&self) -> String {
        self.backend.clone()
    }
}

/// The name in the working folder, with a number if it is taken: nothing is overwritten.
fn free_name(name: &str) -> Arc<std::path::Path> {
    let path = std::path::Path::new(name);
    let (stem, extension) = (path.file_stem().unwrap_or_default(), path.extension().unwrap_or_default());
    let numbered = |n: u32| format!("{}-{n}.{}", stem.to_string_lossy(), extension.to_string_lossy()).into();
    let candidates = std::iter::once(path.to_path_buf()).chain((2..1000).map(numbered));
    let mut names = candidates.skip_while(|candidate: &std::path::PathBuf| candidate.exists());
    names.next().unwrap_or_else(|| path.to_path_buf()).into()
}
