// SPDX-License-Identifier: GPL-3.0-or-later
// What the page does: choose a cloud, run methods on it, open and compare jobs. Panels call it and are told of changes.
import {ApiError, unreachable, type Api} from '../api/client';
import {followJob, pause} from '../api/follow';
import {isEnded, type Job, type Sample, type Submission} from '../api/types';
import {uploadCloud} from '../api/upload';
import type {TableOptions} from '../clouds/table';
import {bytes} from '../words/numbers';
import type {Geometry} from '../worker/geometry';
import {keepCloud, keptCloud} from './kept_clouds';
import {initialState, type ChosenCloud, type ColourBy, type Result, type Side, type State, type Work} from './state';

export interface Run {
  method: string;
  parameters: Record<string, unknown>;
}

function randomKey(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

const kSubmissions = 4;

export class Session {
  readonly state: State = initialState();
  private readonly listeners: ((state: State, what: 'all'|'view'|'work') => void)[] = [];
  /** Of what was begun last. Each has its own signal, and whatever comes after that is aborted changes nothing. */
  private abort = new AbortController();
  /** What the address named when the page was opened, until it is opened or something else is begun. */
  private link: URLSearchParams|undefined = new URLSearchParams(location.search);

  constructor(readonly api: Api, private readonly geometry: Geometry) {}

  onChange(listener: (state: State, what: 'all'|'view'|'work') => void): void {
    this.listeners.push(listener);
  }

  change(part: Partial<State>, what: 'all'|'view'|'work' = 'all'): void {
    Object.assign(this.state, part);
    for (const listener of this.listeners) listener(this.state, what);
  }

  async start(): Promise<void> {
    await this.guard(async () => {
      const [methods, samples] = await Promise.all([this.api.methods(), this.api.samples()]);
      this.change({methods, samples});
      await this.refreshHistory();
      await this.openLink();
    });
  }

  private async openLink(): Promise<void> {
    const [job, other] = [this.link?.get('job'), this.link?.get('with')];
    if (!job) return;
    await this.begin(async (signal) => {
      await this.bring(job, 0, signal);
      if (other && this.state.results[0]) await this.bring(other, 1, signal);
    });
  }

  /** Ends what was begun before, and runs something under a signal of its own. */
  private begin(task: (signal: AbortSignal) => Promise<void>): Promise<void> {
    this.stop();
    const {signal} = this.abort;
    return this.guard(() => task(signal), signal);
  }

  /** Runs something; what goes wrong is shown, unless its signal says that nobody waits for it any more. */
  async guard(task: () => Promise<void>, signal?: AbortSignal): Promise<void> {
    try {
      await task();
    } catch (failure) {
      if (signal?.aborted) return;
      const error = failure instanceof ApiError ?
          failure :
          new ApiError(
              'page', 'This page could not do that', failure instanceof Error ? failure.message : String(failure),
              'Reload the page; your jobs are kept.');
      this.change({
        error,
        notice: '',
        ...(signal && {work: undefined}),
        needsKey: this.state.needsKey || error.code === 'unauthorized'
      });
    }
  }

  async useKey(key: string): Promise<void> {
    this.api.key = key.trim();
    this.change({needsKey: true, error: undefined});
    await this.guard(() => this.refreshHistory());
    if (this.state.error) return;
    this.change({notice: 'The key is accepted.'});
    await this.openLink();
  }

  async refreshHistory(): Promise<void> {
    this.change({history: await this.api.jobs(30)});
  }

  chooseSample(sample: Sample): Promise<void> {
    return this.begin(async (signal) => {
      this.change({error: undefined, notice: `Fetching ${sample.name} …`});
      const body = await this.api.bytes(`samples/${encodeURIComponent(sample.name)}`, () => undefined, signal);
      signal.throwIfAborted();
      await this.chooseFile(new File([body], sample.name));
    });
  }

  chooseFile(file: File): Promise<void> {
    return this.begin(async () => {
      history.replaceState(null, '', location.pathname);
      await this.setCloud(file);
    });
  }

  private replaceCloud(cloud: ChosenCloud|undefined, notice: string): void {
    this.forget();
    this.change({
      cloud,
      results: [undefined, undefined],
      difference: undefined,
      pointed: undefined,
      error: undefined,
      colour: 'none',
      notice
    });
  }

  /** What is begun meanwhile does not end the reading, another cloud does. */
  private async setCloud(file: File, id?: string): Promise<void> {
    const cloud: ChosenCloud = {name: file.name, size: file.size, file, id};
    this.replaceCloud(cloud, `Reading ${file.name} …`);
    await this.readCloud(cloud, file);
    if (this.state.cloud === cloud)
      this.change({notice: ''});
    else if (cloud.data)
      void this.geometry.forget(cloud.data.handle);
  }

  /** Reads the points for the page, as `table` has a text read. */
  private async readCloud(cloud: ChosenCloud, file: File): Promise<void> {
    const {table} = this.state;
    const {data: before} = cloud;
    let data: ChosenCloud['data'];
    let noPreview: string|undefined;
    try {
      data = await this.geometry.loadCloud(await file.arrayBuffer(), table);
    } catch (failure) {
      noPreview = failure instanceof Error ? failure.message : String(failure);
    }
    // Told otherwise meanwhile: whoever did so reads the file again.
    const stale = this.state.cloud === cloud && this.state.table !== table;
    if (stale && data) void this.geometry.forget(data.handle);
    if (stale) return;
    Object.assign(cloud, {data, noPreview});
    if (before) void this.geometry.forget(before.handle);
  }

  /** Says how a text is to be read; the chosen one is read again. */
  setTable(table: TableOptions): void {
    if (JSON.stringify(table) === JSON.stringify(this.state.table)) return;
    this.change({table});
    const {cloud} = this.state;
    const text = cloud?.data ? cloud.data.table !== undefined : cloud?.noPreview !== undefined;
    if (!cloud?.file || !text) return;
    const {file} = cloud;
    void this.guard(async () => {
      await this.readCloud(cloud, file);
      this.change({});
    });
  }

  /** Uploads the cloud if the server has it not, queues a job, follows it and shows its mesh. */
  run(run: Run, side: Side): Promise<void> {
    return this.begin(async (signal) => {
      const {cloud} = this.state;
      if (!cloud)
        throw new ApiError(
            'page', 'There is no cloud yet', 'nothing to reconstruct', 'Drop a file or choose a sample.');
      this.change({error: undefined, notice: ''});
      const cloud_id = cloud.id ?? (await this.upload(cloud, side, signal));
      const job = await this.submit({cloud_id, ...run, outputs: ['mesh.glb', 'report.json', 'log.txt']}, side, signal);
      await this.watch(job, side, signal);
    });
  }

  private async upload(cloud: ChosenCloud, side: Side, signal: AbortSignal): Promise<string> {
    const {file} = cloud;
    if (!file)
      throw new ApiError('page', 'The cloud is not on this device', 'only its mesh is', 'Drop the file again.');
    const total = bytes(file.size);
    this.work({side, what: 'upload', fraction: 0, detail: `0 of ${total}`}, signal);
    cloud.id = await uploadCloud(
        this.api, file, {
          progress: (sent) => this.work(
              {side, what: 'upload', fraction: sent / file.size, detail: `${bytes(sent)} of ${total}`}, signal),
          interrupted: () => this.work(
              {
                side,
                what: 'upload',
                fraction: this.state.work?.fraction,
                detail: 'the connection was lost; trying again where it broke off'
              },
              signal),
        },
        signal);
    void keepCloud(cloud.id, file);
    signal.throwIfAborted();
    return cloud.id;
  }

  /** Sent again under the same key when the answer is lost, it makes no second job. */
  private async submit(submission: Submission, side: Side, signal: AbortSignal): Promise<Job> {
    this.work({side, what: 'submit', detail: 'handing over'}, signal);
    const key = randomKey();
    for (let attempt = 1;; attempt += 1) {
      try {
        // Without the signal: who does not hear the answer does not know which job to cancel.
        const job = await this.api.submit(submission, key);
        if (signal.aborted) await this.dismiss(job);
        signal.throwIfAborted();
        return job;
      } catch (failure) {
        signal.throwIfAborted();
        const again = failure instanceof ApiError && (failure.status === 0 || failure.code === 'queue_full') &&
            attempt < kSubmissions;
        if (failure instanceof ApiError && failure.code === 'cloud_not_found' &&
            this.state.cloud?.id === submission.cloud_id)
          this.state.cloud.id = undefined;
        if (!again) throw failure;
        await pause(1000 * attempt, signal);
        signal.throwIfAborted();
      }
    }
  }

  /** A job that was queued after its page had turned to something else. */
  private async dismiss(job: Job): Promise<void> {
    await this.api.cancel(job.id).catch(() => undefined);
    await this.refreshHistory().catch(() => undefined);
  }

  private work(work: Work, signal: AbortSignal): void {
    if (!signal.aborted) this.change({work}, 'work');
  }

  /** Shows how the job goes, then what became of it. */
  private async watch(begun: Job, side: Side, signal: AbortSignal): Promise<void> {
    let job = begun;
    let phases: string[] = [];
    const show = (fraction: number|undefined, detail: string): void =>
        this.work({side, what: job.status === 'accepted' ? 'queue' : 'run', fraction, detail, job, phases}, signal);
    const place = () => (job.queue_position ? `${job.queue_position} before it in the queue` : 'next in the queue');
    if (side === 0) this.setLink(job.id);
    show(undefined, place());
    const ended = isEnded(job) ?
        job :
        await followJob(
            this.api, job.id, {
              state: (now) => {
                job = now;
                phases = [];
                if (job.status === 'accepted') show(undefined, place());
              },
              progress: (progress, phase) => {
                job = {...job, status: 'running'};
                const words = phase.replaceAll(/[-_]/g, ' ');
                if (words !== '' && phases.at(-1) !== words) phases = [...phases, words];
                show(progress, words);
              },
              log: () => undefined,
              lost: (again) => {
                if (again > 0)
                  show(
                      this.state.work?.fraction,
                      'the connection to the server was lost; the job is safe there. Trying again …');
              },
            },
            signal);
    signal.throwIfAborted();
    if (!ended) return;
    void this.refreshHistory().catch(() => undefined);
    await this.finish(ended, side, signal);
  }

  private async finish(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    if (job.status === 'failed') {
      const error = job.error ? ApiError.of(job.error) : unreachable('the job failed without a reason');
      const parked = job.parked ? ' Its attempts are used up; Try again in the list of jobs starts it anew.' : '';
      throw new ApiError(error.code, error.title, error.detail, error.hint + parked, error.status, error.requestId);
    }
    if (job.status === 'dismissed') {
      this.change({work: undefined, notice: 'The job was cancelled.'});
      return;
    }
    await this.show(job, side, signal);
  }

  /** Opens a job by its id, whatever its state. */
  open(id: string, side: Side): Promise<void> {
    return this.begin((signal) => this.bring(id, side, signal));
  }

  private async bring(id: string, side: Side, signal: AbortSignal): Promise<void> {
    this.change({error: undefined, notice: ''});
    const job = await this.api.job(id, signal);
    signal.throwIfAborted();
    await this.bringCloud(job, side, signal);
    await this.watch(job, side, signal);
  }

  /** The points of a job that was opened by its link, if this device has kept them. */
  private async bringCloud(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    const {cloud} = this.state;
    const id = job.cloud_id ?? undefined;
    if (side === 1 || (id && cloud?.id === id)) return;
    const file = id ? await keptCloud(id) : undefined;
    signal.throwIfAborted();
    if (file)
      await this.setCloud(file, id);
    else
      this.replaceCloud(
          id ? {name: `cloud ${id.slice(0, 8)}`, size: 0, id, noPreview: 'only the server has its points'} : undefined,
          '');
    signal.throwIfAborted();
  }

  private async show(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    const progress = (fraction: number): void =>
        this.work({side, what: 'load', fraction, detail: 'fetching the mesh', job}, signal);
    progress(0);
    const [glb, report] = await Promise.all(
        [this.api.bytes(`v1/jobs/${job.id}/outputs/mesh.glb`, progress, signal), this.api.report(job.id, signal)]);
    signal.throwIfAborted();
    this.work({side, what: 'load', detail: 'measuring the mesh', job}, signal);
    const mesh = await this.geometry.loadMesh(glb);
    if (signal.aborted) void this.geometry.forget(mesh.handle);
    signal.throwIfAborted();
    const results: State['results'] = [...this.state.results];
    const before = results[side];
    results[side] = {job, report, mesh};
    if (before) void this.geometry.forget(before.mesh.handle);
    const colour = this.state.colour === 'difference' ? 'none' : this.state.colour;
    this.setLinks(results);
    this.change({
      results,
      difference: undefined,
      pointed: undefined,
      work: undefined,
      colour,
      look: {...this.state.look, points: false}
    });
    await this.complete();
  }

  /** Measures what the present look needs and has not yet. */
  async complete(): Promise<void> {
    const {cloud, results, look, colour} = this.state;
    // The worker holds what is shown, and may have let go of the others meanwhile.
    const shown = (result: Result|undefined): result is Result =>
        result !== undefined && this.state.results.includes(result);
    for (const result of results) {
      if (!shown(result)) continue;
      const {mesh} = result;
      if (cloud?.data && look.marks && !result.unused && (result.report.quality.unused_points ?? 1) > 0) {
        result.unused = await this.geometry.unused(mesh.handle, cloud.data.handle, result.report.mesh.closed);
        this.change({}, 'view');
      }
      if (look.wireframe && !result.wireframe && shown(result)) {
        result.wireframe = await this.geometry.wireframe(mesh.handle);
        this.change({}, 'view');
      }
      if (colour === 'distance' && cloud?.data && !result.distances && shown(result)) {
        result.distances = await this.geometry.distances(mesh.handle, cloud.data.handle);
        this.change({}, 'view');
      }
    }
    const [first, second] = this.state.results;
    if (colour === 'difference' && first && second && !this.state.difference) {
      this.change({notice: 'Measuring the difference …'});
      const difference = await this.geometry.difference(first.mesh.handle, second.mesh.handle);
      if (shown(first) && shown(second)) this.change({difference, notice: ''});
    }
  }

  setLook(look: Partial<State['look']>): void {
    this.change({look: {...this.state.look, ...look}}, 'view');
    void this.guard(() => this.complete());
  }

  setColour(colour: ColourBy): void {
    this.change({colour});
    void this.guard(() => this.complete());
  }

  async cancel(): Promise<void> {
    const job = this.state.work?.job;
    this.stop();
    this.change({work: undefined, notice: 'Cancelled.'});
    if (job && !isEnded(job)) await this.guard(async () => void (await this.api.cancel(job.id)));
    await this.refreshHistory().catch(() => undefined);
  }

  retry(id: string): Promise<void> {
    return this.begin(async (signal) => {
      await this.api.retry(id);
      signal.throwIfAborted();
      await this.bring(id, 0, signal);
    });
  }

  closeSecond(): void {
    const [first, second] = this.state.results;
    if (second) void this.geometry.forget(second.mesh.handle);
    const results: State['results'] = [first, undefined];
    this.setLinks(results);
    this.change({
      results,
      difference: undefined,
      notice: '',
      colour: this.state.colour === 'difference' ? 'none' : this.state.colour
    });
  }

  private stop(): void {
    this.abort.abort(new Error('something else was begun'));
    this.abort = new AbortController();
    this.link = undefined;
    this.change({work: undefined}, 'work');
  }

  private forget(): void {
    const {cloud, results} = this.state;
    for (const handle of [cloud?.data?.handle, ...results.map((result: Result|undefined) => result?.mesh.handle)]) {
      if (handle !== undefined) void this.geometry.forget(handle);
    }
  }

  private setLink(job: string): void {
    history.replaceState(null, '', `?job=${job}`);
  }

  /** Before the results are shown, because the panel shows the link too. */
  private setLinks([first, second]: State['results']): void {
    if (first) history.replaceState(null, '', `?job=${first.job.id}${second ? `&with=${second.job.id}` : ''}`);
  }
}
