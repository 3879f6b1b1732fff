// Runs the drives of a file under a table: node compare.mjs CORE BEFORE RULE AFTER JSON

import fs from "node:fs";

const [core, before, rule, after, told] = process.argv.slice(2);
const { size, header, row, periods, decisions } = JSON.parse(told);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(core)), {});
const drives = fs.readFileSync(before);
const table = fs.readFileSync(rule);
const rows = (exports.__heap_base.value + 15) & ~15;
const first = rows + row * periods;
const at = first + drives.length;
const missing = at + table.length - exports.memory.buffer.byteLength;
if (missing > 0) exports.memory.grow(Math.ceil(missing / 65536));
const memory = new Uint8Array(exports.memory.buffer);
memory.set(drives, first);
memory.set(table, at);
const began = process.hrtime.bigint();
for (let drive = first; drive < at; drive += size) {
  for (let j = 0; j < decisions; j++) exports.page_decide(drive, at, at + header, periods, rows);
}
const seconds = Number(process.hrtime.bigint() - began) / 1e9;
const all = (drives.length / size) * decisions * periods;
console.log(`${(all / seconds / 1e6).toFixed(2)} million periods a second in WebAssembly`);
fs.writeFileSync(after, memory.slice(first, at));
