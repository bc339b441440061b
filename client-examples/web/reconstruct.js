// SPDX-License-Identifier: GPL-3.0-or-later
// A surfaced server, for pages. EventSource cannot send a key, so events are read with fetch.
const passing = [429, 502, 503, 504];
const sleep = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

/** A problem in words; what does not speak JSON is a proxy in between. */
function said(text, status) {
  try {
    const { title, detail, hint } = JSON.parse(text);
    return `${title}: ${detail}. ${hint}`;
  } catch {
    return `the server answered ${status}`;
  }
}

/** Calls `send` until it gives an answer that is not busy; it gives {status, retryAfter, text()}, or throws without one. */
async function patiently(send, tries = 5) {
  let reason = '';
  for (let attempt = 0; attempt < tries; ++attempt) {
    let pause = 0.5 * 2 ** attempt;
    try {
      const answer = await send();
      if (answer.status < 400) return answer;
      reason = said(await answer.text(), answer.status);
      if (!passing.includes(answer.status)) throw Object.assign(new Error(reason), { refused: true });
      pause = Number(answer.headers.get('retry-after') ?? pause);
    } catch (failure) {
      if (failure.refused) throw failure;
      reason = failure.message;
    }
    await sleep(pause);
  }
  throw new Error(`given up after ${tries} tries; the last said: ${reason}`);
}

/** fetch cannot tell how much it has sent; XMLHttpRequest can. */
const upload = (url, body, headers, tell) => new Promise((resolve, reject) => {
  const request = new XMLHttpRequest();
  request.open('POST', url);
  for (const [name, value] of Object.entries(headers)) request.setRequestHeader(name, value);
  request.upload.onprogress = ({ loaded, total }) => tell('upload', loaded / total);
  request.onload = () => resolve({
    status: request.status,
    headers: { get: (name) => request.getResponseHeader(name) },
    text: async () => request.responseText,
  });
  request.onerror = () => reject(new Error(`no connection to ${url}, or it does not allow this page (--cors-origins)`));
  request.send(body);
});

export function connect(base, key = '') {
  const authorization = key ? { Authorization: `Bearer ${key}` } : {};
  const get = (path, headers = {}) => patiently(() => fetch(base + path, { headers: { ...authorization, ...headers } }));

  /** Events of a job until `done`; where the stream breaks off, a new one goes on. */
  async function* events(job) {
    let [event, last, silent] = ['', {}, 0];
    while (event !== 'done' && ++silent < 5) {
      const { body } = await get(`/v1/jobs/${job}/events`, last);
      const reader = body.pipeThrough(new TextDecoderStream()).getReader();
      let text = '';
      try {
        for (let piece = await reader.read(); !piece.done; piece = await reader.read()) {
          text += piece.value;
          for (let end = text.indexOf('\n\n'); end >= 0; end = text.indexOf('\n\n')) {
            const fields = Object.fromEntries(text.slice(0, end).split('\n').map((line) => line.split(/: (.*)/, 2)));
            text = text.slice(end + 2);
            if (!fields.data) continue;
            [event, last, silent] = [fields.event, { 'Last-Event-ID': fields.id }, 0];
            yield { event, data: JSON.parse(fields.data) };
          }
        }
      } catch {
        await sleep(0.5);
      }
    }
    if (event !== 'done') throw new Error(`no more events of job ${job}`);
  }

  return {
    /** Uploads a cloud and waits for its job; `tell` gets the phase and the share (0..1) that is done. Returns the job's id. */
    async reconstruct(cloud, parameters, tell) {
      const headers = { ...authorization, 'Content-Type': 'application/octet-stream', 'Idempotency-Key': crypto.getRandomValues(new Uint32Array(4)).join('-') };
      const url = `${base}/v1/jobs?${new URLSearchParams(parameters)}`;
      const { id } = JSON.parse(await (await patiently(() => upload(url, cloud, headers, tell))).text());
      for await (const { event, data } of events(id)) {
        if (event === 'progress') tell(data.phase || 'waiting', data.progress);
        if (event === 'done' && data.status !== 'successful') throw new Error(data.error?.detail ?? 'the job was dismissed');
      }
      return id;
    },
    report: async (job) => (await get(`/v1/jobs/${job}/outputs/report.json`)).json(),
    mesh: async (job) => (await get(`/v1/jobs/${job}/outputs/mesh.glb`)).arrayBuffer(),
  };
}
