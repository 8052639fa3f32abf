// The panel: buttons to the hand, a beat every tenth of a second, traces and estimates back.

const $ = (id) => document.getElementById(id);
const known = JSON.parse($("known").textContent);
const SPAN = 10, BEAT = 100; // s that are drawn, ms between beats
const INK = "#1a1a1a", BLUE = "#0072b2", GREY = "#6e6e6e", ORANGE = "#e69f00";
const COLUMNS = ["time", "reference", "position", "current", "model position", "model current", "model force", "force", "low", "high"];
const data = COLUMNS.map(() => []);
let socket = null, fresh = false, beats = 0;

function ask(what, value) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, value }));
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws${location.search}`);
  socket.onopen = () => enable(true);
  socket.onmessage = (event) => show(JSON.parse(event.data));
  socket.onclose = (event) => {
    enable(false);
    const stopped = event.code === 1013 ? "" : "; a stop was sent";
    health(`not connected: ${event.reason || "the panel has ended"}${stopped}`, true);
  };
}

function enable(on) {
  document.querySelectorAll("button.move").forEach((each) => { each.disabled = !on; });
  if (!on) document.body.dataset.state = "lost";
}

function health(text, lost) {
  $("health").textContent = text;
  $("health").classList.toggle("lost", lost);
}

const figure = (value) => Number(value.toPrecision(3)).toString();

function estimate(id, found, unit) {
  $(id).textContent = found ? `${figure(found[0])} ${unit}` : "none yet";
  $(`${id}-band`).textContent = found ? `${figure(found[1])} to ${figure(found[2])} ${unit} (95 %)` : "\u00a0";
}

function show(state) {
  document.body.dataset.state = state.doing || "still";
  document.body.dataset.board = state.board;
  if (known.recognises && document.activeElement !== $("policy")) $("policy").checked = state.policy;
  health(`board: ${state.board}; ${state.samples} samples${state.said ? `; ${state.said}` : ""}`, Boolean(state.said));
  const found = state.recognised;
  if (known.recognises) {
    $("word").textContent = (found && found.word) || "none yet";
    $("rigid").textContent = found && found.word ? `probability of rigid ${found.rigid.toFixed(2)}` : "\u00a0";
    estimate("stiffness", found && found.stiffness && found.stiffness.map((x) => x / 1000), "kN/m");
    estimate("force", found && found.force, "N");
  }
  const band = (found && found.force) || [null, null, null];
  for (const row of state.rows) [...row, ...band].forEach((value, k) => data[k].push(value));
  const [time] = data, from = time.findIndex((each) => each >= time[time.length - 1] - SPAN);
  if (from > 0) data.forEach((each) => each.splice(0, from));
  fresh = fresh || state.rows.length > 0;
}

const line = (stroke, dash, width = 1.6) => ({ stroke, dash, width, points: { show: false }, spanGaps: false });
const CHARTS = [
  { title: "position [rad]", from: ["reference", "position", "model position"], looks: [line(GREY, [2, 3], 1.3), line(INK), line(BLUE, [7, 4])] },
  { title: "current [A]", from: ["current", "model current"], looks: [line(INK), line(BLUE, [7, 4])] },
  { title: "grip force [N]", from: ["model force", "force", "low", "high"], looks: [line(BLUE, [7, 4]), line(ORANGE, undefined, 2), line(ORANGE, [2, 3], 1), line(ORANGE, [2, 3], 1)],
    bands: [{ series: [4, 3], fill: "rgba(230, 159, 0, 0.15)" }] },
];

const charts = CHARTS.map(({ title, looks, bands }, k) => {
  const box = $("plots").appendChild(document.createElement("div"));
  box.className = "chart";
  box.appendChild(document.createElement("b")).textContent = title;
  const axis = { stroke: "#444", grid: { stroke: "#e2e2e2" }, ticks: { stroke: "#bbb" }, font: "11px system-ui, sans-serif" };
  const last = k === CHARTS.length - 1;
  return new uPlot({
    width: 300, height: 110, legend: { show: false }, cursor: { show: false }, bands,
    scales: { x: { time: false } },
    axes: [{ ...axis, size: last ? 26 : 8, values: last ? (u, all) => all.map((x) => `${x} s`) : () => [] }, { ...axis, size: 50 }],
    series: [{}, ...looks],
  }, [[], ...looks.map(() => [])], box);
});

function size() {
  const width = $("plots").clientWidth - 26, room = window.innerWidth > 700 ? $("plots").clientHeight : 0;
  charts.forEach((each) => each.setSize({ width, height: Math.max(105, Math.floor(room / charts.length) - 2) }));
}

function draw() {
  if (fresh) {
    fresh = false;
    charts.forEach((chart, k) => chart.setData([data[0], ...CHARTS[k].from.map((name) => data[COLUMNS.indexOf(name)])]));
  }
  requestAnimationFrame(draw);
}

$("close").onclick = () => ask("close");
$("open").onclick = () => ask("open");
$("stop").onclick = () => ask("stop");
$("go").onclick = () => ask("reference", Number($("reference").value));
$("run").onclick = () => ask("experiment", $("experiment").value);
if (known.recognises) $("policy").onchange = () => ask("policy", $("policy").checked);
$("reference").oninput = () => { $("angle").textContent = `${Number($("reference").value).toFixed(2)} rad`; };
window.addEventListener("keydown", (event) => event.key === "Escape" && ask("stop"));
document.addEventListener("visibilitychange", () => document.hidden && ask("stop"));
window.addEventListener("resize", size);
setInterval(() => ask("beat", beats++), BEAT);
enable(false);
size();
connect();
requestAnimationFrame(draw);
