// Time runs, is dragged and stepped; everything else follows it. `window.viewer` is the page's state.

const byId = (id) => document.getElementById(id);

async function start() {
  const data = JSON.parse(byId("data").textContent);
  const scenes = [];
  for (const each of data.scenes) scenes.push(await unpackScene(each));
  let most = 1;
  for (const { tension } of scenes) for (const x of tension.values) most = Math.max(most, x);
  let hardest = 1;
  for (const { pushes } of scenes) for (const x of pushes.values) hardest = Math.max(hardest, Math.abs(x));
  ARROW = Math.min(0.8, 26 / hardest);
  const state = window.viewer = {
    times: timeline(scenes), index: 0, playing: false, speed: 0.1, ghost: true, effect: true,
    frames: 0, seconds: 0, scenes, ready: false,
  };
  state.time = state.times[0];
  makePlayer(state, data, scenes, most);
}

// The scene drawn as ghost: the second recording, or what has no effects; null where switched off.
function ghostOf(state, { ghost }) {
  if (!state.ghost) return null;
  return ghost.with !== null && (state.effect || ghost.without === null) ? ghost.with : ghost.without;
}

// What the two hands of the picture are, and which of them is over.
function drawnWords(states, time) {
  return `At ${time.toFixed(4)} s · ` + states.filter((each) => each).map(({ scene, over }, k) => {
    const words = `${k ? "dashed" : "solid"}: ${scene.name}${scene.effects ? `, with ${scene.effects}` : ""}`;
    const last = scene.time[scene.time.length - 1];
    return over ? `${words} (over: recorded from ${scene.time[0].toFixed(3)} to ${last.toFixed(3)} s)` : words;
  }).join(" · ");
}

function makePlayer(state, data, scenes, most) {
  const first = scenes[0], times = state.times, scrub = byId("scrub");
  const seek = (time) => { jump(state, nearest(times, time)); draw(); };
  const plots = makePlots(byId("plots"), scenes, times, seek);
  const readout = makeReadout(byId("readout"), plots, scenes);
  const ghosts = scenes.length > 1 ? [scenes[scenes.length - 1]] : [];
  const space = makeSpace(byId("space"), [first, ...ghosts], most);
  scrub.max = times.length - 1;

  function draw(light = false) {
    const ghost = ghostOf(state, data), time = times[state.index];
    const states = [sampleAt(first, time)];
    states.push(ghost === null ? null : sampleAt(scenes[ghost], time));
    space.draw(states);
    drawPlanes(byId("planes"), states, data.fingers, most);
    drawWires(byId("wires"), states, data.layout, data.fingers, most);
    plots.cursor(time);
    if (light) return;
    scrub.value = state.index;
    byId("clock").value = `${time.toFixed(4)} s`;
    byId("drawn").textContent = drawnWords(states, time);
    readout.write(rowsAt(scenes, time));
  }

  function refresh() {
    const visible = scenes.map((_, k) => k === 0 || k === ghostOf(state, data));
    plots.show(visible);
    readout.show(visible);
    plots.size(state.printed);
    draw();
  }

  function play(on = !state.playing) {
    if (on && state.index === times.length - 1) jump(state, 0);
    state.playing = on;
    byId("play").textContent = on ? "Stop" : "Play";
    byId("play").setAttribute("aria-pressed", on);
    if (on) requestAnimationFrame((now) => run(now, now));
    else draw();
  }

  function run(now, before) {
    if (!state.playing) return;
    const gone = (now - before) / 1000;
    state.seconds += gone;
    state.frames += 1;
    state.time += state.speed * gone;
    if (state.time >= times[times.length - 1]) state.time = times[0];
    state.index = nearest(times, state.time);
    draw(state.frames % 4 !== 0);
    requestAnimationFrame((next) => run(next, now));
  }

  const step = (count) => {
    if (state.playing) play(false);
    jump(state, Math.min(times.length - 1, Math.max(0, state.index + count)));
    draw();
  };
  Object.assign(state, { seek, step, play, refresh, redraw: draw, plots });
  state.turn = () => ({ x: space.illo.rotate.x, y: space.illo.rotate.y });
  state.values = () => scenes.map((scene, k) => {
    const row = rowsAt(scenes, times[state.index])[k];
    return { name: scene.name, row, recorded: picked(scene.recorded, row), simulated: picked(scene.simulated, row) };
  });
  listen(state, data, scrub, space);
  refresh();
  state.ready = true;
}

// The row of each scene at a time, null where it is over.
const rowsAt = (scenes, time) => scenes.map((scene) => sampleAt(scene, time))
  .map(({ row, over }) => (over ? null : row));

const picked = (table, row) => row === null ? {} : Object.fromEntries(Object.entries(table).map(([name, each]) => [name, each[row]]));

function jump(state, index) {
  state.index = index;
  state.time = state.times[index];
}

function listen(state, data, scrub, space) {
  const redraw = () => state.playing || state.redraw();
  const { with: kept, without } = data.ghost;
  byId("ghost-label").hidden = kept === null && without === null;
  byId("effect-label").hidden = kept === null || without === null;
  const { effects } = state.scenes[kept === null ? 0 : kept];
  byId("ghost-label").lastElementChild.textContent = kept === null ? `beside it, without ${effects} (G or E)` : "second hand (G)";
  byId("effect-label").lastElementChild.textContent = `second hand with ${effects} (E)`;
  byId("effect").checked = state.effect;
  byId("play").onclick = () => state.play();
  byId("back").onclick = () => state.step(-1);
  byId("ahead").onclick = () => state.step(1);
  byId("view").onclick = () => { space.reset(); redraw(); };
  scrub.oninput = () => { jump(state, Number(scrub.value)); redraw(); };
  byId("speed").onchange = (event) => { state.speed = Number(event.target.value); };
  for (const name of ["ghost", "effect"])
    byId(name).onchange = (event) => { state[name] = event.target.checked; state.refresh(); };
  byId("space").addEventListener("pointerdown", () => window.addEventListener("pointermove", redraw));
  window.addEventListener("pointerup", () => window.removeEventListener("pointermove", redraw));
  window.addEventListener("resize", () => state.refresh());
  window.addEventListener("beforeprint", () => { state.printed = true; state.refresh(); });
  window.addEventListener("afterprint", () => { state.printed = false; state.refresh(); });
  window.addEventListener("keydown", (event) => press(event, state, space, redraw));
}

const NATIVE = ["BUTTON", "SELECT"];  // they answer to keys themselves
const TURNED = 0.12;  // rad a key

function press(event, state, space, redraw) {
  const { target } = event, box = target.type === "checkbox";
  if (event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
  if ((NATIVE.includes(target.tagName) || box) && [" ", "Enter"].includes(event.key)) return;
  const far = event.shiftKey ? 10 : 1, toggle = (id) => byId(`${id}-label`).hidden || byId(id).click();
  const turn = (axis, by) => { space.illo.rotate[axis] += by; redraw(); };
  const keys = {
    " ": () => state.play(), ArrowLeft: () => state.step(-far), ArrowRight: () => state.step(far),
    Home: () => state.step(-Infinity), End: () => state.step(Infinity),
    a: () => turn("y", -TURNED), d: () => turn("y", TURNED), w: () => turn("x", -TURNED), s: () => turn("x", TURNED),
    g: () => toggle("ghost"), e: () => toggle(byId("effect-label").hidden ? "ghost" : "effect"),
    0: () => { space.reset(); redraw(); },
  };
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

start();
