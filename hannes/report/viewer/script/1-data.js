// What the page carries, unpacked: see packing.py. Lengths in m, forces in N, angles in rad.

async function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = packed.kind === "whole" ? 4 : 8, count = planes.length / size;
  const mixed = new Uint8Array(planes.length);
  for (let plane = 0; plane < size; plane++)
    for (let k = 0; k < count; k++) mixed[k * size + plane] = planes[plane * count + k];
  if (packed.kind === "exact") return new Float64Array(mixed.buffer);
  return summed(new Int32Array(mixed.buffer), packed);
}

function summed(steps, { rows, quantum }) {
  const columns = steps.length / rows, values = new Float64Array(steps.length);
  for (let column = 0; column < columns; column++)
    for (let row = 0, sum = 0; row < rows; row++)
      values[column * rows + row] = quantum * (sum += steps[column * rows + row]);
  return { rows, columns, values, at: (row, column) => values[column * rows + row] };
}

const ARRAYS = ["time", "points", "contacts", "pushes", "carts", "motor", "pose", "tension", "stretch"];

async function unpackScene(packed) {
  const scene = { ...packed, recorded: {}, simulated: {} };
  for (const name of ARRAYS) scene[name] = await unpack(packed[name]);
  for (const name in packed.recorded) scene.recorded[name] = await unpack(packed.recorded[name]);
  for (const name in packed.simulated)
    scene.simulated[name] = (await unpack(packed.simulated[name])).values;
  return scene;
}

function nearest(times, time) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return time - times[low] <= times[high] - time ? low : high;
}

// Times of all recordings together: where two samples are of one instant, once [s].
function timeline(scenes) {
  const all = scenes.flatMap((scene) => Array.from(scene.time)).sort((a, b) => a - b);
  const least = 0.05 * Math.min(...scenes.map(stepOf));
  return all.filter((time, k) => k === 0 || time - all[k - 1] > least);
}

function stepOf({ time }) {
  return (time[time.length - 1] - time[0]) / (time.length - 1);
}

// The sample of a scene at a time; `over` where its recording has ended or has not begun.
function sampleAt(scene, time) {
  const { time: own } = scene, step = stepOf(scene);
  const over = time > own[own.length - 1] + step || time < own[0] - step;
  return { scene, row: nearest(own, time), over };
}
