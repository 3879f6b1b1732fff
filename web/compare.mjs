// Runs the drives of a file in WebAssembly: node compare.mjs CORE BEFORE AFTER JSON

import fs from "node:fs";

const [core, before, after, told] = process.argv.slice(2);
const { size, periods, k_s } = JSON.parse(told);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(core)), {});
const drives = fs.readFileSync(before);
const at = (exports.__heap_base.value + 15) & ~15;
const missing = at + drives.length + 65536 - exports.memory.buffer.byteLength;
if (missing > 0) exports.memory.grow(Math.ceil(missing / 65536));
const memory = new Uint8Array(exports.memory.buffer);
memory.set(drives, at);
const n = drives.length / size;
const weights = at + drives.length;
new Float32Array(exports.memory.buffer, weights, n).fill(k_s);
const began = process.hrtime.bigint();
exports.sim_run(at, n, periods, 0, 1, weights, weights + 4 * n);
const seconds = Number(process.hrtime.bigint() - began) / 1e9;
console.log(`${((n * periods) / seconds / 1e6).toFixed(2)} million periods a second in WebAssembly`);
fs.writeFileSync(after, memory.slice(at, at + drives.length));
