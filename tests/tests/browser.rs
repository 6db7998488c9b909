//! The page in a real browser: it opens, draws, computes in its worker, and explains itself when it cannot.

use std::time::Duration;

use anyhow::Result;
use endcomfort_tests::browser::Browser;

const A_WHILE: Duration = Duration::from_secs(60);

/// A picture with fewer colours than this shows no interface, only a background.
const COLORS_OF_AN_INTERFACE: usize = 50;

fn assert_sound(browser: &Browser) -> Result<()> {
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "the console says:\n{}", complaints.join("\n"));
    Ok(())
}

#[test]
fn the_page_opens_draws_and_its_console_stays_clean() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.open("")?;
    browser.wait_until_it_runs()?;
    let first_picture_ms = browser.run("return window.endcomfort.first_picture_ms", &[])?;
    println!("first picture after {first_picture_ms} ms");
    let picture = browser.screenshot("page")?;
    assert!(picture.colors() > COLORS_OF_AN_INTERFACE, "{} colours: is it blank?", picture.colors());
    assert!(first_picture_ms.as_f64().is_some_and(|ms| ms > 0.0 && ms < 10_000.0), "{first_picture_ms} ms");
    assert_sound(&browser)
}

#[test]
fn the_canvas_fills_the_window_and_nothing_scrolls() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.open("")?;
    browser.wait_until_it_runs()?;
    let sizes = browser.run(
        "const canvas = document.getElementById('view'), root = document.documentElement;
         return [canvas.clientWidth - innerWidth, canvas.clientHeight - innerHeight,
                 canvas.width - innerWidth * devicePixelRatio, canvas.height - innerHeight * devicePixelRatio,
                 root.scrollWidth - innerWidth, root.scrollHeight - innerHeight]",
        &[],
    )?;
    assert_eq!(sizes, serde_json::json!([0, 0, 0, 0, 0, 0]), "canvas, its pixels, and the page against the window");
    Ok(())
}

#[test]
fn the_worker_answers() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.open("")?;
    browser.wait_until_it_runs()?;
    let status = browser.wait_for_status("an answer of the worker", A_WHILE, |status| status["running"] == false)?;
    assert!(status["revision"].as_u64().is_some_and(|revision| revision > 0), "{status}");
    assert_sound(&browser)
}

#[test]
fn the_address_can_force_webgl() -> Result<()> {
    // This browser offers both, so WebGL2 is chosen because the address says so.
    let browser = Browser::with_webgpu()?;
    browser.open("?renderer=webgl")?;
    browser.wait_until_it_runs()?;
    assert_eq!(browser.status()?["backend"], "WebGL2");
    let picture = browser.screenshot("webgl")?;
    assert!(picture.colors() > COLORS_OF_AN_INTERFACE, "{} colours: is it blank?", picture.colors());
    assert_sound(&browser)
}

#[test]
fn the_address_can_force_webgpu() -> Result<()> {
    // A software adapter's picture does not reach the screenshot, so the page's own word has to do.
    let browser = Browser::with_webgpu()?;
    browser.open("?renderer=webgpu")?;
    browser.wait_until_it_runs()?;
    assert_eq!(browser.status()?["backend"], "WebGPU");
    assert_sound(&browser)
}

#[test]
fn webgpu_in_software_gives_way_to_webgl() -> Result<()> {
    let browser = Browser::with_webgpu()?;
    browser.open("")?;
    browser.wait_until_it_runs()?;
    assert_eq!(browser.status()?["backend"], "WebGL2");
    Ok(())
}

#[test]
fn a_browser_without_graphics_is_told_so() -> Result<()> {
    let browser = Browser::without_graphics()?;
    browser.open("")?;
    let words = browser.wait_for_explanation()?;
    browser.screenshot("without-graphics")?;
    assert!(words.contains("neither WebGPU nor WebGL2"), "{words}");
    assert!(words.contains("hardware acceleration"), "{words}");
    Ok(())
}

#[test]
fn an_address_that_asks_for_absent_webgpu_is_told_so() -> Result<()> {
    let browser = Browser::without_graphics()?;
    browser.open("?renderer=webgpu")?;
    let words = browser.wait_for_explanation()?;
    assert!(words.contains("no WebGPU adapter"), "{words}");
    Ok(())
}

#[test]
fn a_file_that_does_not_arrive_is_told() -> Result<()> {
    for file in ["*endcomfort*.wasm", "*endcomfort*.js"] {
        let browser = Browser::with_webgl()?;
        browser.block(&[file])?;
        browser.open("")?;
        let words = browser.wait_for_explanation()?;
        assert!(words.contains("could not be loaded"), "without {file}: {words}");
        assert!(words.contains("Reload"), "without {file}: {words}");
    }
    Ok(())
}
