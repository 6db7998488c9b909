// Loads the program, chooses how it draws, and says in words what is wrong when either cannot be done.
//
// Everything else is Rust (web/src). `cargo xtask dist` writes the final file names into `files`.

const files = {
  glue: "./endcomfort.js",
  module: "./endcomfort.wasm",
  worker: "./worker.js",
  moduleBytes: 0,
};

const element = (id) => document.getElementById(id);

/** A reason why the page cannot run, in words. */
class Failure extends Error {
  constructor(sentence, advice, detail = "") {
    super(sentence);
    this.advice = advice;
    this.detail = String(detail);
  }
}

const hasFailed = () => element("status").className === "failed";

function say(sentence, fraction) {
  if (hasFailed()) {
    return; // a file that still arrives must not talk over the reason why it is of no use
  }
  element("sentence").textContent = sentence;
  if (fraction === undefined) {
    element("bar").removeAttribute("value");
  } else {
    element("bar").value = fraction;
  }
}

function showFailure(title, failure) {
  element("title").textContent = title;
  element("sentence").textContent = failure.message;
  element("advice").textContent = failure.advice;
  element("detail").textContent = failure.detail;
  element("detail").hidden = failure.detail === "";
  element("status").className = "failed";
}

/** A module of one function that uses a 128-bit vector: old browsers refuse it. */
const vectorProbe = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

function checkWebAssembly() {
  if (typeof WebAssembly !== "object") {
    throw new Failure(
      "This browser does not run WebAssembly, in which Endcomfort is written.",
      "Any current Firefox, Chrome, Edge or Safari does. In a hardened browser, allow WebAssembly for this page.",
    );
  }
  if (!WebAssembly.validate(vectorProbe)) {
    throw new Failure(
      "This browser’s WebAssembly has no vector instructions, which Endcomfort computes with.",
      "Please update it: Chrome and Edge have them since version 91, Firefox since 89, Safari since 16.4.",
    );
  }
}

/** Whether WebGPU is there on real hardware. A software adapter draws slower than WebGL2, and some draw nothing. */
async function webgpuIsSound() {
  try {
    const adapter = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
    if (!adapter) {
      return { present: false, sound: false };
    }
    const software = adapter.info?.isFallbackAdapter || adapter.isFallbackAdapter || false;
    return { present: true, sound: !software && adapter.limits.maxTextureDimension2D >= 8192 };
  } catch {
    return { present: false, sound: false };
  }
}

function hasWebgl2() {
  const context = document.createElement("canvas").getContext("webgl2");
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return context !== null;
}

/** "webgpu" or "webgl": what the address asks for, else WebGPU where it is sound, else WebGL2. */
async function chooseRenderer() {
  const wish = new URLSearchParams(location.search).get("renderer");
  if (wish !== "webgl") {
    const { present, sound } = await webgpuIsSound();
    if (sound || (present && wish === "webgpu")) {
      return "webgpu";
    }
    if (wish === "webgpu") {
      throw new Failure(
        "The address asks for WebGPU (?renderer=webgpu), and this browser offers no WebGPU adapter.",
        "Remove ?renderer=webgpu from the address to draw with WebGL2.",
      );
    }
  }
  if (hasWebgl2()) {
    return "webgl";
  }
  throw new Failure(
    "This browser offers neither WebGPU nor WebGL2, so nothing can be drawn.",
    "Switch on hardware acceleration in its settings, or try a current Firefox, Chrome, Edge or Safari. " +
      "Without any graphics, the command line still works: `endcomfort plan pick mustard --json`.",
  );
}

async function fetchModule() {
  const response = await fetch(new URL(files.module, import.meta.url));
  if (!response.ok) {
    throw new Error(`${files.module}: the server answered ${response.status} ${response.statusText}`);
  }
  let received = 0;
  const counter = new TransformStream({
    transform(chunk, controller) {
      received += chunk.byteLength;
      const megabytes = (bytes) => (bytes / 1e6).toFixed(1);
      say(`Loading ${megabytes(received)} of ${megabytes(files.moduleBytes)} MB`, received / files.moduleBytes);
      controller.enqueue(chunk);
    },
  });
  const headers = { "Content-Type": "application/wasm" };
  return WebAssembly.compileStreaming(new Response(response.body.pipeThrough(counter), { headers }));
}

async function load() {
  try {
    return await Promise.all([import(new URL(files.glue, import.meta.url)), fetchModule()]);
  } catch (error) {
    throw new Failure(
      navigator.onLine
        ? "A file of this page could not be loaded."
        : "A file of this page could not be loaded: this machine is offline.",
      "Reload the page. If it was just updated, an old copy may be in the way: reload with Shift held down.",
      error,
    );
  }
}

/** Waits for the frame that follows the program's first picture. */
async function firstPicture(program) {
  do {
    await new Promise(requestAnimationFrame);
  } while (program.pictures() === 0);
  return performance.now();
}

/** Shows what has no handler of its own: a trap inside the program. */
function watchForTraps() {
  const onError = (error) => {
    // A panic has already said what happened, in better words.
    if (error instanceof WebAssembly.RuntimeError && !hasFailed()) {
      showFailure(
        "Endcomfort has stopped",
        new Failure("The program met a fault and cannot go on.", "Reload the page to start again.", error),
      );
    }
  };
  addEventListener("error", (event) => onError(event.error));
  addEventListener("unhandledrejection", (event) => onError(event.reason));
}

/** Asks for a file when the menu does; it comes in as if it had been dropped. */
function openFiles(program) {
  addEventListener("endcomfort-pick", () => {
    const input = document.createElement("input");
    input.type = "file";
    input.accept = ".pcd,.ply,.xyz,.json,.reach,.urdf,.srdf,.zip,.obj,.stl,.glb,.png";
    input.multiple = true;
    input.addEventListener("change", async () => {
      for (const file of input.files) {
        program.bring(file.name, new Uint8Array(await file.arrayBuffer()));
      }
      program.bring_end();
    });
    input.click();
  });
}

/** Folders nested deeper than this are no robot's. */
const deepestFolder = 12;

/** Hands every file below an entry of a drop to the program, with its path. */
async function bringEntry(program, entry, path, depth) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    program.bring(path, new Uint8Array(await file.arrayBuffer()));
    return;
  }
  if (depth > deepestFolder) {
    return;
  }
  const reader = entry.createReader();
  // The browser lists a folder a hundred entries at a time; an empty list is the end.
  for (;;) {
    const entries = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (entries.length === 0) {
      return;
    }
    for (const inner of entries) {
      if (!inner.name.startsWith(".")) {
        await bringEntry(program, inner, `${path}/${inner.name}`, depth + 1);
      }
    }
  }
}

/** A drop with a folder in it is read here: the canvas takes files alone. */
function takeFolders(program) {
  addEventListener(
    "drop",
    async (event) => {
      const items = [...(event.dataTransfer?.items ?? [])];
      const entries = items.map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry);
      if (!entries.some((entry) => entry.isDirectory)) {
        return;
      }
      event.preventDefault();
      event.stopImmediatePropagation();
      element("view").dispatchEvent(new DragEvent("dragleave", { bubbles: true })); // nothing hovers any more
      try {
        for (const entry of entries) {
          await bringEntry(program, entry, entry.name, 0);
        }
      } catch (error) {
        console.warn(`A file of the folder could not be read: ${error}`); // the program says what is missing
      }
      program.bring_end();
    },
    { capture: true },
  );
}

// ---- As a part of somebody else's page (`?embed=1`): docs/embed.md says what is sent and answered.

const isEmbedded = !["0", null].includes(new URLSearchParams(location.search).get("embed"));

/** What a message may ask for: `message` in, its result out. */
function deeds(program) {
  return {
    load_scene: ({ scene }) => program.open_scene(typeof scene === "string" ? scene : JSON.stringify(scene ?? null)),
    load_demo: ({ name }) => {
      program.set_demo(String(name));
      if (JSON.parse(program.status()).demo !== name) {
        throw new Error(`there is no demo named ${JSON.stringify(name)}`);
      }
    },
    seek: ({ time_s }) => {
      if (!Number.isFinite(time_s)) {
        throw new Error(`time_s: found ${JSON.stringify(time_s)}, wanted seconds`);
      }
      program.seek(time_s);
    },
    play: () => program.set_playing(true),
    pause: () => program.set_playing(false),
    status: () => JSON.parse(program.status()),
    plan: () => {
      const lines = program.plan_json();
      if (lines === undefined) {
        throw new Error("there is no plan yet; the event \"stage\" tells when there is");
      }
      return lines.split("\n").map((line) => JSON.parse(line));
    },
    link: () => program.link(),
  };
}

function answerMessages(program) {
  const known = deeds(program);
  addEventListener("message", ({ data, source, origin }) => {
    if (data?.endcomfort !== 1 || typeof data.do !== "string" || !source) {
      return;
    }
    const answer = { endcomfort: 1, id: data.id };
    try {
      if (!Object.hasOwn(known, data.do)) {
        throw new Error(`there is no ${JSON.stringify(data.do)}; there are ${Object.keys(known).join(", ")}`);
      }
      Object.assign(answer, { ok: true, result: known[data.do](data) ?? null });
    } catch (error) {
      Object.assign(answer, { ok: false, error: String(error?.message ?? error) });
    }
    // A page without an origin (a file, a sandbox) can only be named by the window that asked.
    source.postMessage(answer, origin === "null" || origin === "" ? "*" : origin);
  });
  const around = document.referrer ? new URL(document.referrer).origin : "*";
  const tell = (event) => parent !== window && parent.postMessage({ endcomfort: 1, ...event }, around);
  addEventListener("endcomfort", ({ detail }) => tell(JSON.parse(detail)));
  tell({ event: "ready" });
}

/** The wheel belongs to the page around until the view has been clicked, so that nobody gets stuck while reading. */
function leaveTheWheel() {
  let isChosen = false;
  addEventListener("pointerdown", () => (isChosen = true), true);
  addEventListener("blur", () => (isChosen = false));
  addEventListener("wheel", (event) => isChosen || event.stopImmediatePropagation(), { capture: true, passive: true });
  document.documentElement.classList.add("embedded");
}

async function main() {
  checkWebAssembly();
  if (isEmbedded) {
    leaveTheWheel();
  }
  const renderer = chooseRenderer();
  renderer.catch(() => {}); // it is awaited, and its failure shown, below
  const [program, module] = await load();
  say("Starting");
  await program.default({ module_or_path: module });
  watchForTraps();
  const worker = new URL(files.worker, import.meta.url).href;
  const chosen = await renderer;
  try {
    await program.start(module, worker, chosen);
  } catch (error) {
    if (hasFailed()) {
      return; // a panic has said why
    }
    throw new Failure(
      chosen === "webgpu"
        ? "WebGPU is there, but drawing with it could not be started."
        : "WebGL2 is there, but drawing with it could not be started.",
      chosen === "webgpu"
        ? "Add ?renderer=webgl to the address to draw with WebGL2 instead."
        : "Close other tabs that draw in 3D and reload; if it stays, update the browser or the graphics driver.",
      error,
    );
  }
  // What a script or a test may ask and do; see web/src/page.rs.
  window.endcomfort = {
    status: program.status,
    plan_json: program.plan_json,
    load_cloud: program.load_cloud,
    set_demo: program.set_demo,
    play: () => program.set_playing(true),
    pause: () => program.set_playing(false),
    seek: program.seek,
    select_step: program.select_step,
    compare_objectives: program.compare_objectives,
    set_shape: (parameters) => program.set_shape(JSON.stringify(parameters)),
    undo: program.undo,
    redo: program.redo,
    link: program.link,
    open_link: program.open_link,
    session: program.session,
    save_picture: (wanted) => program.save_picture(JSON.stringify(wanted ?? {})),
    save_animation: (wanted) => program.save_animation(JSON.stringify(wanted ?? {})),
    open_files: (files) => {
      files.forEach(({ path, bytes }) => program.bring(path, bytes));
      program.bring_end();
    },
    first_picture_ms: await firstPicture(program),
  };
  if (!hasFailed()) {
    say("Endcomfort is ready", 1);
    element("status").className = "running";
    openFiles(program);
    takeFolders(program);
    if (isEmbedded) {
      answerMessages(program);
    } else {
      // Keys work from the start; in somebody else's page they are that page's until somebody clicks here.
      element("view").focus({ preventScroll: true });
    }
    // Another link in the address of the same page loads nothing anew.
    addEventListener("hashchange", () => {
      if (location.hash.startsWith("#s=")) {
        try {
          program.open_link(location.hash);
        } catch (error) {
          console.warn(`The link was not opened: ${error}`); // the page has said so as well
        }
      }
    });
  }
}

main().catch((error) => {
  console.warn(error);
  showFailure(
    "Endcomfort cannot start here",
    error instanceof Failure
      ? error
      : new Failure("Starting the program failed.", "Reload the page; if it stays, update the browser.", error),
  );
});
