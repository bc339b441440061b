// SPDX-License-Identifier: GPL-3.0-or-later
// A proxy that is no better than real networks: the first submission is answered 503, the second one reaches the server
// but its answer gets lost, and the first event stream breaks off after its first event.
import http from 'node:http';

export async function startFlakyProxy(target) {
  const did = { busy: 0, lost: 0, cut: 0, resumed: false };
  const proxy = http.createServer((request, response) => {
    const submission = request.method === 'POST' && request.url.startsWith('/v1/jobs?');
    if (submission && did.busy === 0) {
      did.busy += 1;
      request.resume().on('end', () => {
        response.writeHead(503, { 'content-type': 'application/problem+json', 'retry-after': '1' });
        response.end(JSON.stringify({ title: 'The queue is full', detail: 'of the proxy.', hint: 'Try again.' }));
      });
      return;
    }
    const events = request.url.endsWith('/events');
    if (events && request.headers['last-event-id']) did.resumed = true;
    const forwarded = http.request(target + request.url, { method: request.method, headers: request.headers }, (answer) => {
      if (submission && did.lost === 0) {
        did.lost += 1;
        answer.resume().on('end', () => request.socket.destroy());
        return;
      }
      response.writeHead(answer.statusCode, answer.headers);
      if (events && did.cut === 0) {
        did.cut += 1;
        let seen = Buffer.alloc(0);
        answer.on('data', (bytes) => {
          seen = Buffer.concat([seen, bytes]);
          const end = seen.indexOf('\n\n') + 2;
          if (end < 2) return;
          response.write(seen.subarray(0, end), () => request.socket.destroy());
          answer.destroy();
        });
        return;
      }
      answer.pipe(response);
    });
    forwarded.on('error', () => response.destroy());
    request.pipe(forwarded);
  });
  await new Promise((resolve) => proxy.listen(0, '127.0.0.1', resolve));
  return {
    base: `http://127.0.0.1:${proxy.address().port}`,
    done: () => ({ ...did }),
    stop: () => new Promise((resolve) => {
      proxy.closeAllConnections();
      proxy.close(resolve);
    }),
  };
}
