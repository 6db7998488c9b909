// Drives Endcomfort in a frame. What can be asked is in docs/embed.md.

const frame = document.getElementById("frame");
const origin = new URL(frame.src).origin;
const waiting = new Map();
let asked = 0;

function log(text) {
  const line = document.createElement("li");
  line.textContent = text;
  document.getElementById("log").append(line);
}

/** Asks the frame for something; resolves with its result. */
function ask(deed, fields = {}) {
  const id = ++asked;
  frame.contentWindow.postMessage({ endcomfort: 1, id, do: deed, ...fields }, origin);
  return new Promise((resolve, reject) => waiting.set(id, { resolve, reject }));
}

addEventListener("message", ({ data, source }) => {
  if (source !== frame.contentWindow || data?.endcomfort !== 1) {
    return;
  }
  if (data.event) {
    log([data.event, data.stage, data.state, data.reason].filter(Boolean).join(" "));
    return;
  }
  const { resolve, reject } = waiting.get(data.id) ?? {};
  waiting.delete(data.id);
  data.ok ? resolve?.(data.result) : reject?.(new Error(data.error));
});

function onClick(id, act) {
  document.getElementById(id).addEventListener("click", () => act().then(log, (error) => log(`refused: ${error.message}`)));
}

onClick("jar", async () => {
  await ask("load_demo", { name: "jar" });
  return "The jar is opened.";
});

onClick("half", async () => {
  const { duration_s } = await ask("status");
  await ask("pause");
  await ask("seek", { time_s: duration_s / 2 });
  return `Now at ${(duration_s / 2).toFixed(1)} s of ${duration_s.toFixed(1)} s.`;
});

onClick("link", async () => `Link: ${await ask("link")}`);
