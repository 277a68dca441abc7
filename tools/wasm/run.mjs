// Prints the hashes of a module: node run.mjs punctual_wasm.wasm
import { readFileSync } from "node:fs";
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(process.argv[2])));
if (!exports.has_no_time()) throw new Error("a budget of time was spent without a clock");
const at = exports.answers();
const length = new DataView(exports.memory.buffer).getUint32(at, true);
process.stdout.write(Buffer.from(exports.memory.buffer, at + 4, length));
