//! The page's side: starts the interface on the canvas, and answers scripts and tests.
//!
//! `web/boot.js` offers the functions below as `window.endcomfort`:
//! `status()`, `plan_json()`, `load_cloud(name, bytes)`, `set_demo(name)`, `play()`, `pause()`, `seek(seconds)`,
//! `select_step(name)`, `compare_objectives()`, `set_shape({ a: 0.05, … })`, `undo()`, `redo()`, `link()`,
//! `open_link(text)`, `session()`, `save_picture({ width: 1920, … })`, `save_animation({ format: "gif", … })`,
//! `open_files([{ path, bytes }, …])`, and the
//! number `first_picture_ms`, counted from the moment the browser began to open
//! the page. With `?embed=1` it also answers the messages of the page around it, see `docs/embed.md`.

use std::cell::RefCell;

use eframe::{WebOptions, WebRunner, egui, egui_wgpu, wgpu};
use endcomfort::studio::BuiltInStudio;
use endcomfort::viewer::{App, Command, StartOptions, ThemeChoice};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::dom;
use crate::host::WebHost;

thread_local! {
    static PAGE: RefCell<Option<Page>> = const { RefCell::new(None) };
    /// Files of a folder, until all have been read.
    static BROUGHT: RefCell<Vec<(String, Vec<u8>)>> = const { RefCell::new(Vec::new()) };
}

/// What the functions below act on.
#[derive(Clone)]
struct Page {
    runner: WebRunner,
    context: egui::Context,
}

/// Starts the interface on the canvas `#view`.
///
/// * `module`: the compiled `WebAssembly.Module`, for the workers.
/// * `worker_url`: address of `worker.js`.
/// * `renderer`: `webgpu` or `webgl`.
///
/// # Errors
/// What the browser or the interface says when it cannot start.
#[wasm_bindgen]
pub async fn start(module: JsValue, worker_url: String, renderer: String) -> Result<(), JsValue> {
    // The runner's own hook, installed on top of this one, writes the message and the stack to the console.
    std::panic::set_hook(Box::new(|info| {
        dom::show_failure(
            "Endcomfort has stopped",
            "The program met a fault and cannot go on.",
            "Reload the page to start again. Please report what is written below, with what you did before.",
            &info.to_string(),
        );
    }));
    // Warnings of the libraries go to the console; a second start finds the logger in place.
    let _is_already_there = eframe::WebLogger::init(log::LevelFilter::Warn);
    let canvas: HtmlCanvasElement = dom::document()
        .and_then(|document| document.get_element_by_id("view"))
        .and_then(|element| element.dyn_into().ok())
        .ok_or("the page has no canvas #view")?;

    let (backends, backend) = match renderer.as_str() {
        "webgpu" => (wgpu::Backends::BROWSER_WEBGPU, "WebGPU"),
        _ => (wgpu::Backends::GL, "WebGL2"),
    };
    let runner = WebRunner::new();
    let page = runner.clone();
    runner
        .start(
            canvas,
            web_options(backends),
            Box::new(move |creation| {
                let context = creation.egui_ctx.clone();
                let host = WebHost::new(context.clone(), backend, module, worker_url);
                let app = App::new(creation, Box::new(host), Box::new(BuiltInStudio::default()), start_options())?;
                PAGE.set(Some(Page { runner: page, context }));
                Ok(Box::new(app))
            }),
        )
        .await
}

/// WebGL2's limits everywhere, so that one renderer serves both, but textures as large as the adapter allows.
fn web_options(backends: wgpu::Backends) -> WebOptions {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = backends;
    setup.device_descriptor = std::sync::Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("endcomfort"),
        required_limits: wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
        ..wgpu::DeviceDescriptor::default()
    });
    let wgpu_options = egui_wgpu::WgpuConfiguration {
        wgpu_setup: egui_wgpu::WgpuSetup::CreateNew(setup),
        ..egui_wgpu::WgpuConfiguration::default()
    };
    WebOptions { wgpu_options, ..WebOptions::default() }
}

/// What the address asks for: `?demo=mustard&gallery=0&theme=dark&embed=1#s=…`; without a demo the gallery is open.
fn start_options() -> StartOptions {
    let theme = match dom::query("theme").as_deref() {
        Some("dark") => ThemeChoice::Dark,
        Some("light") => ThemeChoice::Light,
        _ => ThemeChoice::System,
    };
    let demo = dom::query("demo");
    let gallery = dom::query("gallery").map_or(demo.is_none(), |wanted| wanted != "0");
    let is_embedded = dom::query("embed").is_some_and(|wanted| wanted != "0");
    StartOptions { demo, gallery, theme, link: dom::link(), is_embedded, files: Vec::new() }
}

/// How many pictures have been drawn.
#[wasm_bindgen]
pub fn pictures() -> f64 {
    // A JavaScript number counts exactly far beyond any session's pictures.
    with_page(|page| page.context.cumulative_frame_nr() as f64).unwrap_or(0.0)
}

/// State of the interface as JSON: revision, stages, error, time, backend, … (`App::status_json`).
#[wasm_bindgen]
pub fn status() -> Option<String> {
    with_app(|app, _| app.status_json())
}

/// The plan on the timeline in the format of `endcomfort plan --json`, if there is one.
#[wasm_bindgen]
pub fn plan_json() -> Option<String> {
    with_app(|app, _| app.plan_json()).flatten()
}

/// Opens a file as if it had been dropped onto the page.
#[wasm_bindgen]
pub fn load_cloud(name: String, bytes: Vec<u8>) {
    with_app(|app, context| app.open_file(context, name, bytes));
}

/// Takes a file that belongs to others, by its path; [`bring_end`] opens all of them together.
#[wasm_bindgen]
pub fn bring(path: String, bytes: Vec<u8>) {
    BROUGHT.with_borrow_mut(|files| files.push((path, bytes)));
}

/// Opens the files that were taken, as if they had been dropped together.
#[wasm_bindgen]
pub fn bring_end() {
    let files = BROUGHT.take();
    with_app(|app, context| app.open_files(context, files));
}

/// Opens a demo by its name.
#[wasm_bindgen]
pub fn set_demo(name: &str) {
    with_app(|app, context| app.open_demo(context, name));
}

/// Plays or pauses the plan.
#[wasm_bindgen]
pub fn set_playing(playing: bool) {
    with_app(|app, context| app.set_playing(context, playing));
}

/// Goes to a moment of the plan, seconds from its start.
#[wasm_bindgen]
pub fn seek(time_s: f64) {
    with_app(|app, context| app.seek(context, time_s));
}

/// Shows a step in the inspector: `scene`, `segment`, `fit`, `grasps`, `rank`, `plan` or `play`.
///
/// # Errors
/// A sentence when there is no such step.
#[wasm_bindgen]
pub fn select_step(name: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.select_step(context, name)).unwrap_or(Ok(())).map_err(|reason| reason.into())
}

/// Fits the examined cluster with each of the five objectives; the status lists them under `objectives`.
#[wasm_bindgen]
pub fn compare_objectives() {
    with_app(|app, context| app.compare_objectives(context));
}

/// Sets parameters of the examined cluster's shape, a JSON object with fields of `fit.superquadric` in the status.
///
/// # Errors
/// A sentence when there is no fit, or when the parameters are those of no superquadric.
#[wasm_bindgen]
pub fn set_shape(parameters: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.set_shape(context, parameters)).unwrap_or(Ok(())).map_err(|reason| reason.into())
}

/// Takes the last edit back.
#[wasm_bindgen]
pub fn undo() {
    with_app(|app, context| app.apply(context, Command::Undo));
}

/// Does the edit again that was taken back last.
#[wasm_bindgen]
pub fn redo() {
    with_app(|app, context| app.apply(context, Command::Redo));
}

/// The address of this view, which opens it again.
///
/// # Errors
/// A sentence if the scene cannot be written.
#[wasm_bindgen]
pub fn link() -> Result<Option<String>, JsValue> {
    with_app(|app, _| app.link()).transpose().map_err(JsValue::from)
}

/// Opens a link: an address with `#s=…`, or that part alone.
///
/// # Errors
/// What is wrong with it; the page says it to the person as well.
#[wasm_bindgen]
pub fn open_link(text: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.open_link(context, text)).unwrap_or(Ok(())).map_err(JsValue::from)
}

/// Opens a scene, given as JSON.
///
/// # Errors
/// What is wrong with it.
#[wasm_bindgen]
pub fn open_scene(json: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.open_scene(context, json)).unwrap_or(Ok(())).map_err(JsValue::from)
}

/// Everything that is needed to open this view again, a dropped cloud included, as JSON.
///
/// # Errors
/// A sentence if the scene cannot be written.
#[wasm_bindgen]
pub fn session() -> Result<Option<String>, JsValue> {
    with_app(|app, _| app.session()).transpose().map_err(JsValue::from)
}

/// Saves a picture of the view, as a download; the sentence about it stands among the status's messages.
///
/// # Errors
/// What is wrong with the object.
#[wasm_bindgen]
pub fn save_picture(wanted: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.save_picture(context, wanted)).unwrap_or(Ok(())).map_err(JsValue::from)
}

/// Saves the plan as an animation, as a download once all frames are drawn.
///
/// # Errors
/// What is wrong with the object.
#[wasm_bindgen]
pub fn save_animation(wanted: &str) -> Result<(), JsValue> {
    with_app(|app, context| app.save_animation(context, wanted)).unwrap_or(Ok(())).map_err(JsValue::from)
}

fn with_page<T>(act: impl FnOnce(&Page) -> T) -> Option<T> {
    PAGE.with_borrow(|page| page.as_ref().map(act))
}

/// Acts on the interface; `None` before it has started and after a panic.
fn with_app<T>(act: impl FnOnce(&mut App, &egui::Context) -> T) -> Option<T> {
    let page = with_page(Page::clone)?;
    let mut app = page.runner.app_mut::<App>()?;
    Some(act(&mut app, &page.context))
}
