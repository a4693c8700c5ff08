// SPDX-License-Identifier: MIT
// ONNX Runtime for bench/peers.py. Arguments: the folder of the package, threads, inputs (float32), their width, then
// NAME=FILE.onnx. For each line on standard input: "check N" prints the outputs of the
// first N inputs, "time BATCH ROUNDS SECONDS" the seconds per call of each model in each round.
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import { createInterface } from 'node:readline';

const [packages, threads, inputs, width, ...models] = process.argv.slice(2);
const ort = createRequire(`${packages}/`)('onnxruntime-node');
const bytes = readFileSync(inputs);
const x = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
const sessions = {};
for (const model of models) {
  const [name, path] = model.split('=');
  sessions[name] = await ort.InferenceSession.create(path, {
    intraOpNumThreads: Number(threads), interOpNumThreads: 1, graphOptimizationLevel: 'all', executionMode: 'sequential' });
}

const feed = (n, first = 0) =>
  ({ x: new ort.Tensor('float32', x.subarray(first * width, (first + n) * width), [n, Number(width)]) });
const output = (session, results) => results[session.outputNames[0]];

async function check(n) {
  const out = {};
  for (const name in sessions) out[name] = Array.from(output(sessions[name], await sessions[name].run(feed(n))).data);
  return out;
}

// Milliseconds: of the clock, or with NQM_PEERS_CPU the processor time of all threads / threads, which excludes other programs.
function clock() {
  if (!process.env.NQM_PEERS_CPU) return performance.now();
  const used = process.cpuUsage();
  return (used.user + used.system) / 1000 / threads;
}

async function time(batch, rounds, seconds) {
  const out = {};
  const feeds = [feed(batch), feed(batch, 1), feed(batch, 2)];
  for (const name in sessions) {
    const session = sessions[name];
    await session.run(feeds[0]);
    out[name] = [];
    for (let round = 0; round < rounds; ++round) {
      const begin = clock();
      let n = 0;
      do await session.run(feeds[n++ % 3]); while (clock() - begin < 1000 * seconds);
      out[name].push((clock() - begin) / 1000 / n);
    }
  }
  return out;
}

console.log(JSON.stringify({ version: ort.env.versions.node }));
for await (const line of createInterface({ input: process.stdin })) {
  const [word, ...numbers] = line.split(' ');
  console.log(JSON.stringify(await (word === 'check' ? check : time)(...numbers.map(Number))));
}
