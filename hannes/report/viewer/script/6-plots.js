// Channels over time by uPlot, one line for the time over all; what was recorded is solid, simulations are dashed.

const TITLES = { leader_tension: "leader tension" };
const ORDER = ["position", "current", "duty", "force", "sensor", "leader_tension", "supply"];
const LOOKS = {
  recorded: [{ stroke: INK, width: 1.6 }, { stroke: "#777", width: 1.3 }, { stroke: "#777", width: 1.3 }],
  simulated: [{ stroke: "#0072b2", width: 1.6, dash: [7, 4] }, { stroke: "#d55e00", width: 1.6, dash: [3, 3] }, { stroke: "#d55e00", width: 1.6, dash: [3, 3] }],
};

// Rows of the table and lines of the charts: one for each channel, scene, and recorded or simulated.
function seriesOf(scenes, name) {
  return scenes.flatMap((scene, k) => ["recorded", "simulated"]
    .filter((kind) => scene[kind][name])
    .map((kind) => ({ scene: k, kind, values: scene[kind][name], look: LOOKS[kind][k] })));
}

const moves = (values) => values.some((x) => Math.abs(x - values[0]) > 1e-9);

function channels(scenes) {
  const unit = (name) => scenes.map((each) => each.units[name]).find((each) => each) || "1";
  return ORDER.map((name) => ({ name, unit: unit(name), series: seriesOf(scenes, name) }))
    .filter(({ series }) => series.some(({ values }) => moves(values)));
}

const labelled = ({ name, unit }) => (TITLES[name] || name) + (unit === "1" ? "" : ` [${unit}]`);

const PRINTED = 700, PRINTED_HIGH = 96;  // px of an A4 page between its margins, and of a chart there

function makePlots(element, scenes, times, onSeek) {
  const shown = channels(scenes), charts = [], span = [times[0], times[times.length - 1]];
  for (const channel of shown) {
    const box = element.appendChild(document.createElement("div"));
    box.className = "chart";
    box.appendChild(document.createElement("b")).textContent = labelled(channel);
    const tables = channel.series.map(({ scene, values }) => [scenes[scene].time, values]);
    const joined = tables.length > 1 ? uPlot.join(tables) : tables[0];
    const lines = channel.series.map(({ look, kind, scene }) => ({ ...look, spanGaps: true, points: { show: false }, label: `${kind} ${scene}` }));
    const last = channel === shown[shown.length - 1];
    const chart = new uPlot(options(lines, last, span), joined, box);
    scrubbing(chart, onSeek);
    charts.push(chart);
  }
  const size = (printed = false) => {
    const room = element.parentElement.clientHeight - document.getElementById("readout").offsetHeight - legend.offsetHeight - 8;
    const wide = window.innerWidth > 900 ? Math.max(70, Math.floor(room / charts.length)) : 120;
    const width = printed ? PRINTED : element.clientWidth, height = printed ? PRINTED_HIGH : wide;
    charts.forEach((each) => each.setSize({ width, height }));
  };
  const legend = document.getElementById("legend"), entries = legendOf(legend, scenes, shown);
  const line = element.appendChild(document.createElement("div"));
  line.id = "cursor";
  const cursor = (time) => {
    const [first] = charts;
    if (!first) return;
    const left = first.valToPos(time, "x");
    line.hidden = !(left >= 0 && left <= first.over.clientWidth);
    line.style.transform = `translateX(${Math.round(left + first.over.offsetLeft)}px)`;
  };
  const show = (visible) => {
    charts.forEach((each, n) => shown[n].series.forEach(({ scene }, k) =>
      each.series[k + 1].show !== visible[scene] && each.setSeries(k + 1, { show: visible[scene] })));
    entries.forEach(({ scene, entry }) => (entry.hidden = !visible[scene]));
  };
  return { size, cursor, show, shown, charts };
}

// What each kind of line stands for: a piece of it and words.
function legendOf(element, scenes, shown) {
  const kinds = new Map();
  for (const { series } of shown)
    for (const { scene, kind, look } of series) kinds.set(`${scene} ${kind}`, { scene, kind, look });
  return [...kinds.values()].sort((a, b) => a.scene - b.scene).map(({ scene, kind, look }) => {
    const { name, own, drawnBy, recorded } = scenes[scene], alone = !Object.keys(recorded).length;
    const words = alone ? name : kind === "recorded" ? `${name}${own ? "" : ", recorded"}` : `${name}, ${own ? "simulated anew" : `simulated: ${drawnBy || "its own hand"}`}`;
    const entry = element.appendChild(document.createElement("span"));
    entry.innerHTML = `<svg width="34" height="8" aria-hidden="true"><path d="M1 4h32" fill="none" stroke="${look.stroke}" stroke-width="2" stroke-dasharray="${(look.dash || []).join(" ")}"/></svg>`;
    entry.append(` ${words}`);
    return { scene, entry };
  });
}

function options(lines, last, span) {
  const axis = { stroke: "#444", grid: { stroke: "#e2e2e2" }, ticks: { stroke: "#bbb" }, font: "11px system-ui, sans-serif" };
  return {
    width: 400, height: 100, padding: [6, 8, 0, 0], legend: { show: false },
    cursor: { show: false },
    scales: { x: { time: false, range: span } },
    axes: [{ ...axis, show: true, size: last ? 26 : 8, values: last ? undefined : () => [] }, { ...axis, size: 52, space: 18 }],
    series: [{}, ...lines],
  };
}

// Pressing and dragging on a chart moves the page's time; one line over all charts shows it.
function scrubbing({ over, posToVal }, onSeek) {
  const seek = (event) => onSeek(posToVal(event.clientX - over.getBoundingClientRect().left, "x"));
  over.style.touchAction = "pan-y";
  over.addEventListener("pointerdown", (event) => {
    over.setPointerCapture(event.pointerId);
    seek(event);
  });
  over.addEventListener("pointermove", (event) => over.hasPointerCapture(event.pointerId) && seek(event));
}
