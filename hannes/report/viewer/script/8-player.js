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
    time: scenes[0].time[0], index: 0, playing: false, speed: 0.1, ghost: true, effect: data.effect,
    frames: 0, seconds: 0, scenes, ready: false,
  };
  makePlayer(state, data, scenes, most);
}

// The scene drawn as ghost, by the effect's switch; null where there is none or it is switched off.
function ghostOf(state, data) {
  const number = state.effect ? data.ghost.with : data.ghost.without;
  return state.ghost && number !== null ? number : null;
}

function makePlayer(state, data, scenes, most) {
  const first = scenes[0], times = first.time, scrub = byId("scrub");
  const seek = (time) => { jump(state, nearest(times, time)); draw(); };
  const plots = makePlots(byId("plots"), scenes, seek);
  const readout = makeReadout(byId("readout"), plots, scenes);
  const ghosts = scenes.length > 1 ? [scenes[scenes.length - 1]] : [];
  const space = makeSpace(byId("space"), [first, ...ghosts], most);
  scrub.max = times.length - 1;

  function draw(light = false) {
    const ghost = ghostOf(state, data), index = state.index;
    const states = [{ scene: first, row: index }];
    states.push(ghost === null ? null : { scene: scenes[ghost], row: nearest(scenes[ghost].time, times[index]) });
    space.draw(states);
    drawPlanes(byId("planes"), states, data.fingers, most);
    drawWires(byId("wires"), states, data.layout, data.fingers, most);
    plots.cursor(times[index]);
    if (light) return;
    scrub.value = index;
    byId("clock").value = `${times[index].toFixed(4)} s`;
    readout.write(scenes.map((each) => nearest(each.time, times[index])));
  }

  function refresh() {
    const visible = scenes.map((_, k) => k === 0 || k === ghostOf(state, data));
    plots.show(visible);
    readout.show(visible);
    plots.size();
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
  Object.assign(state, { seek, step, play, refresh, redraw: draw });
  state.values = () => scenes.map((scene) => ({
    name: scene.name, row: nearest(scene.time, times[state.index]),
    recorded: picked(scene.recorded, nearest(scene.time, times[state.index])),
    simulated: picked(scene.simulated, nearest(scene.time, times[state.index])) }));
  listen(state, data, scrub, space);
  refresh();
  state.ready = true;
}

const picked = (table, row) => Object.fromEntries(Object.entries(table).map(([name, each]) => [name, each[row]]));

function jump(state, index) {
  state.index = index;
  state.time = state.scenes[0].time[index];
}

function listen(state, data, scrub, space) {
  const redraw = () => state.playing || state.redraw();
  const { with: kept, without } = data.ghost;
  byId("ghost-label").hidden = kept === null && without === null;
  byId("effect-label").hidden = kept === null || without === null;
  byId("effect").checked = state.effect;
  byId("play").onclick = () => state.play();
  byId("back").onclick = () => state.step(-1);
  byId("ahead").onclick = () => state.step(1);
  byId("view").onclick = () => { space.reset(); redraw(); };
  scrub.oninput = () => { jump(state, Number(scrub.value)); redraw(); };
  byId("speed").onchange = (event) => { state.speed = Number(event.target.value); };
  for (const name of ["ghost", "effect"])
    byId(name).onchange = (event) => { state[name] = event.target.checked; state.refresh(); };
  space.illo.onDragMove = function (pointer, x, y) {
    Zdog.Illustration.prototype.onDragMove.call(this, pointer, x, y);
  };
  byId("space").addEventListener("pointerdown", () => window.addEventListener("pointermove", redraw));
  window.addEventListener("pointerup", () => window.removeEventListener("pointermove", redraw));
  window.addEventListener("resize", () => state.refresh());
  window.addEventListener("beforeprint", () => state.refresh());
  window.addEventListener("keydown", (event) => press(event, state, space, redraw));
}

function press(event, state, space, redraw) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
  const far = event.shiftKey ? 10 : 1, toggle = (id) => !byId(`${id}-label`).hidden && byId(id).click();
  const keys = {
    " ": () => state.play(), ArrowLeft: () => state.step(-far), ArrowRight: () => state.step(far),
    Home: () => state.step(-Infinity), End: () => state.step(Infinity),
    g: () => toggle("ghost"), e: () => toggle("effect"), 0: () => { space.reset(); redraw(); },
  };
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

start();
