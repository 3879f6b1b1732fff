// The compiled core and its memory. Where numbers lie is told by the layout that the build wrote.

const PAGE = 65536;
const ROOM = 4 * PAGE; // working records of two drives, besides the initial memory
const DEGREES = 180 / Math.PI;

// What is plotted: a column of a trace, or the length of a vector of two, and its factor.
const CURVES = (rpm) => ({
  speed_ref: ["omega_m_ref", null, 1 / rpm],
  speed: ["omega_m", null, 1 / rpm],
  load: ["tau_load", null, 1],
  torque: ["tau", null, 1],
  err: ["theta_e_err", null, DEGREES],
  err_hfi: ["theta_e_err_hfi", null, DEGREES],
  err_observer: ["theta_e_err_smo", null, DEGREES],
  k_s: ["k_s", null, 1],
  voltage: ["u_alpha", "u_beta", 1],
  limit: ["u_dc", null, 1 / Math.sqrt(3)],
  current: ["i_d", "i_q", 1],
});

export class Core {
  static async load(wasm, image, layout) {
    const { instance } = await WebAssembly.instantiate(wasm, {});
    return new Core(instance.exports, image, layout);
  }

  constructor(exports, image, layout) {
    this.lib = exports;
    this.layout = layout;
    const base = (exports.__heap_base.value + 15) & ~15;
    const lacking = base + image.length + ROOM - exports.memory.buffer.byteLength;
    if (lacking > 0) exports.memory.grow(Math.ceil(lacking / PAGE));
    const buffer = exports.memory.buffer; // never grows again, so views stay valid
    this.bytes = new Uint8Array(buffer);
    this.view = new DataView(buffer);
    this.image = base;
    this.bytes.set(image, base);
    this.next = base + image.length;
    this.rowLength = layout.trace.length;
    this.rowsAt = this.room(8 * this.rowLength * layout.rows);
    this.rows = new Float64Array(buffer, this.rowsAt, this.rowLength * layout.rows);
    this.signalsAt = this.room(4 * layout.signals.length);
    this.signals = new Float32Array(buffer, this.signalsAt, layout.signals.length);
    this.tellCurves(CURVES(layout.rpm));
  }

  // Writes the curves where page_range reads them.
  tellCurves(curves) {
    this.curveNames = Object.keys(curves);
    const n = this.curveNames.length;
    this.curvesAt = this.room(16 * n);
    const column = (name) => (name === null ? -1 : this.layout.trace.indexOf(name));
    Object.values(curves).forEach(([first, other, factor], c) => {
      this.write(this.curvesAt + 16 * c, "i32", column(first));
      this.write(this.curvesAt + 16 * c + 4, "i32", column(other));
      this.write(this.curvesAt + 16 * c + 8, "f64", factor);
    });
    this.leastAt = this.room(4 * n);
    this.mostAt = this.room(4 * n);
    this.least = new Float32Array(this.bytes.buffer, this.leastAt, n);
    this.most = new Float32Array(this.bytes.buffer, this.mostAt, n);
  }

  // Least and largest value of every curve over the first rows, in its order.
  findRange(rows) {
    const { rowsAt, curvesAt, curveNames, leastAt, mostAt } = this;
    this.lib.page_range(rowsAt, rows, curvesAt, curveNames.length, leastAt, mostAt);
  }

  // Address of so many free bytes.
  room(size) {
    const at = (this.next + 15) & ~15;
    this.next = at + size;
    return at;
  }

  copy(from, to, size) {
    this.bytes.copyWithin(to, from, from + size);
  }

  read(at, kind) {
    switch (kind) {
      case "f32": return this.view.getFloat32(at, true);
      case "f64": return this.view.getFloat64(at, true);
      case "u32": return this.view.getUint32(at, true);
      default: return this.view.getInt32(at, true);
    }
  }

  write(at, kind, value) {
    switch (kind) {
      case "f32": this.view.setFloat32(at, value, true); break;
      case "f64": this.view.setFloat64(at, value, true); break;
      case "u32": this.view.setUint32(at, value, true); break;
      default: this.view.setInt32(at, value, true);
    }
  }
}
