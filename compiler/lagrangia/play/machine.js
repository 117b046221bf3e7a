// The C run time of runtime/fmi/play.c: numbers by value reference; a call that fails leaves its reason in `message`.
async function unpacked(text) {
  return new Response(new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
class Machine {
  static async made(program, image, sizes, inputs) {  // inputs over time, where they are given: { rows, table }
    let memory = null;
    const clock = (id, precision, at) => { new DataView(memory.buffer).setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true); return 0; };
    const { instance } = await WebAssembly.instantiate(await unpacked(program), { wasi_snapshot_preview1: { clock_time_get: clock } });
    memory = instance.exports.memory;
    return new Machine(instance.exports, new Uint8Array(await unpacked(image)), sizes, inputs);
  }
  constructor(calls, image, sizes, inputs) {
    this.calls = calls; this.sizes = sizes;
    calls._initialize();
    const at = calls.lag_play_room(image.length);
    new Uint8Array(calls.memory.buffer).set(image, at);
    this.player = calls.lag_play_new(at);
    this.places = calls.lag_play_room(8 * sizes.n + 8);
    this.inputs = inputs && { rows: inputs.rows, table: new Float64Array(bytes(inputs.table)), at: 0 };
    if (this.inputs) this.inputs.at = calls.lag_play_room(8 * this.inputs.table.length);
    if (this.message) throw new Error("the scene " + this.message);
  }
  get message() {
    const all = new Uint8Array(this.calls.memory.buffer), at = this.calls.lag_play_message(this.player);
    return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
  }
  numbers(at, count) { return at ? new Float64Array(this.calls.memory.buffer, at, count).slice() : null; }
  begin(given, tolerance, stop) {  // from the start, with [reference, value] of what is not as declared
    this.calls.lag_play_reset(this.player);
    if (this.inputs) {  // as they were given: what was set since is held no more
      const { rows, table, at } = this.inputs;
      new Float64Array(this.calls.memory.buffer, at, table.length).set(table);
      if (this.calls.lag_play_inputs(this.player, at, rows)) return false;
    }
    for (const [reference, value] of given) if (this.calls.lag_play_set(this.player, reference, value)) return false;
    return !this.calls.lag_play_begin(this.player, tolerance, stop);
  }
  set(reference, value) { return !this.calls.lag_play_set(this.player, reference, value); }
  step(h) { return this.calls.lag_play_step(this.player, h) <= 1; }  // a warning is no failure
  values() { return this.numbers(this.calls.lag_play_values(this.player), this.sizes.values); }
  events() { const at = this.calls.lag_play_events(this.player); return this.numbers(at + 8, this.numbers(at, 1)[0]); }  // times of those since the last call
  drawing(q) {  // at other positions, where they are given
    if (q) new Float64Array(this.calls.memory.buffer, this.places, q.length).set(q);
    return this.numbers(this.calls.lag_play_drawing(this.player, q ? this.places : 0), this.sizes.drawing);
  }
}
