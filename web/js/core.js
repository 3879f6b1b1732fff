// The compiled core and its memory. Where numbers lie is told by the layout that the build wrote.

const PAGE = 65536;
const ROOM = 4 * PAGE; // working records of two drives, besides the initial memory

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
