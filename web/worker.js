// The worker: the same program as the page, computing instead of drawing. Its first message is the compiled module;
// every later one is a request (web/src/worker.rs).

import init, { start_worker } from "./endcomfort.js";

self.onmessage = async ({ data: module }) => {
  self.onmessage = null;
  try {
    await init({ module_or_path: module });
    start_worker();
    self.postMessage("ready");
  } catch (error) {
    self.postMessage(`The worker could not start: ${error}`);
  }
};
