// A k_s table in the core's memory: header and node values, as the firmware holds them.

export class Table {
  constructor(core) {
    this.core = core;
    this.at = core.room(core.layout.sizes.table);
    this.valuesAt = core.room(4 * core.layout.most_nodes);
  }

  load(rule) {
    const core = this.core;
    this.axes = rule.axes;
    this.n = rule.axes.reduce((n, axis) => n * axis.n, 1);
    this.slice = this.n / rule.axes[0].n; // nodes at each position of the first axis
    core.copy(core.image + rule.at, this.at, core.layout.sizes.table);
    core.copy(core.image + rule.values, this.valuesAt, 4 * this.n);
    this.values = new Float32Array(core.bytes.buffer, this.valuesAt, this.n);
    this.check();
  }

  // Sets a node, or with `all` every node at its position of the first axis.
  set(node, value, all) {
    const first = all ? node - (node % this.slice) : node;
    this.values.fill(value, first, all ? first + this.slice : node + 1);
    this.seal();
  }

  // Both checksums, as an export would write them; then the check that the firmware makes.
  seal() {
    const { lib, layout } = this.core;
    const field = layout.table_fields;
    const values = lib.ks_values_crc(this.at, this.valuesAt);
    this.core.write(this.at + field.crc_values[0], "u32", values >>> 0);
    this.core.write(this.at + field.crc_header[0], "u32", lib.ks_header_crc(this.at) >>> 0);
    this.check();
  }

  check() {
    this.refused = this.core.lib.ks_table_check(this.at, this.valuesAt, 0);
  }

  nodeAt(axis, j) {
    const { lo, hi, n } = this.axes[axis];
    return lo + ((hi - lo) * j) / (n - 1);
  }
}
