// What the page does: choose a cloud, run methods on it, open and compare jobs. Panels call it and are told of changes.
import { ApiError, unreachable, type Api } from '../api/client';
import { followJob } from '../api/follow';
import { isEnded, type Job, type Sample, type Submission } from '../api/types';
import { uploadCloud } from '../api/upload';
import { bytes } from '../words/numbers';
import type { Geometry } from '../worker/geometry';
import { keepCloud, keptCloud } from './kept_clouds';
import { initialState, type ChosenCloud, type ColourBy, type Result, type Side, type State, type Work } from './state';

export interface Run {
  method: string;
  parameters: Record<string, unknown>;
}

function randomKey(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

const kSubmissions = 4;
const pause = (milliseconds: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, milliseconds));

export class Session {
  readonly state: State = initialState();
  private readonly listeners: ((state: State, what: 'all' | 'view' | 'work') => void)[] = [];
  private abort = new AbortController();

  constructor(readonly api: Api, private readonly geometry: Geometry) {}

  onChange(listener: (state: State, what: 'all' | 'view' | 'work') => void): void {
    this.listeners.push(listener);
  }

  change(part: Partial<State>, what: 'all' | 'view' | 'work' = 'all'): void {
    Object.assign(this.state, part);
    for (const listener of this.listeners) listener(this.state, what);
  }

  async start(): Promise<void> {
    await this.guard(async () => {
      const [methods, samples] = await Promise.all([this.api.methods(), this.api.samples()]);
      this.change({ methods, samples });
      await this.refreshHistory();
      // Opening the first changes the address.
      const link = new URLSearchParams(location.search);
      const [job, other] = [link.get('job'), link.get('with')];
      if (job) await this.open(job, 0);
      if (job && other) await this.open(other, 1);
    });
  }

  /** Runs something; what goes wrong is shown. */
  async guard(task: () => Promise<void>): Promise<void> {
    try {
      await task();
    } catch (failure) {
      if (this.abort.signal.aborted && !(failure instanceof ApiError)) return;
      const error = failure instanceof ApiError ? failure
        : new ApiError('page', 'This page could not do that', failure instanceof Error ? failure.message : String(failure), 'Reload the page; your jobs are kept.');
      this.change({ error, work: undefined, needsKey: this.state.needsKey || error.code === 'unauthorized' });
    }
  }

  async useKey(key: string): Promise<void> {
    this.api.key = key.trim();
    this.change({ needsKey: true, error: undefined });
    await this.guard(() => this.refreshHistory());
    if (!this.state.error) this.change({ notice: 'The key is accepted.' });
  }

  async refreshHistory(): Promise<void> {
    this.change({ history: await this.api.jobs(30) });
  }

  chooseSample(sample: Sample): Promise<void> {
    return this.guard(async () => {
      const body = await this.api.bytes(`samples/${encodeURIComponent(sample.name)}`, () => undefined);
      await this.chooseFile(new File([body], sample.name));
    });
  }

  async chooseFile(file: File): Promise<void> {
    this.stop();
    history.replaceState(null, '', location.pathname);
    await this.setCloud(file);
  }

  private async setCloud(file: File): Promise<void> {
    this.forget();
    const cloud: ChosenCloud = { name: file.name, size: file.size, file };
    this.change({ cloud, results: [undefined, undefined], difference: undefined, pointed: undefined, error: undefined, colour: 'none', notice: `Reading ${file.name} …` });
    try {
      cloud.data = await this.geometry.loadCloud(await file.arrayBuffer());
    } catch (failure) {
      cloud.noPreview = failure instanceof Error ? failure.message : String(failure);
    }
    if (this.state.cloud === cloud) this.change({ cloud, notice: '' });
  }

  /** Uploads the cloud if the server has it not, queues a job, follows it and shows its mesh. */
  run(run: Run, side: Side): Promise<void> {
    this.stop();
    const { signal } = this.abort;
    return this.guard(async () => {
      const { cloud } = this.state;
      if (!cloud) throw new ApiError('page', 'There is no cloud yet', 'nothing to reconstruct', 'Drop a file or choose a sample.');
      this.change({ error: undefined, notice: '' });
      const cloud_id = cloud.id ?? (await this.upload(cloud, side, signal));
      const job = await this.submit({ cloud_id, ...run, outputs: ['mesh.glb', 'report.json', 'log.txt'] }, side);
      await this.watch(job, side, signal);
    });
  }

  private async upload(cloud: ChosenCloud, side: Side, signal: AbortSignal): Promise<string> {
    const { file } = cloud;
    if (!file) throw new ApiError('page', 'The cloud is not on this device', 'only its mesh is', 'Drop the file again.');
    const total = bytes(file.size);
    this.work({ side, what: 'upload', fraction: 0, detail: `0 of ${total}` });
    cloud.id = await uploadCloud(this.api, file, {
      progress: (sent) => this.work({ side, what: 'upload', fraction: sent / file.size, detail: `${bytes(sent)} of ${total}` }),
      interrupted: () => this.work({ side, what: 'upload', fraction: this.state.work?.fraction, detail: 'the connection was lost; trying again where it broke off' }),
    }, signal);
    void keepCloud(cloud.id, file);
    return cloud.id;
  }

  /** Sent again under the same key when the answer is lost, it makes no second job. */
  private async submit(submission: Submission, side: Side): Promise<Job> {
    this.work({ side, what: 'submit', detail: 'handing over' });
    const key = randomKey();
    for (let attempt = 1; ; attempt += 1) {
      try {
        return await this.api.submit(submission, key);
      } catch (failure) {
        const again = failure instanceof ApiError && (failure.status === 0 || failure.code === 'queue_full') && attempt < kSubmissions;
        if (failure instanceof ApiError && failure.code === 'cloud_not_found' && this.state.cloud) this.state.cloud.id = undefined;
        if (!again) throw failure;
        await pause(1000 * attempt);
      }
    }
  }

  private work(work: Work): void {
    this.change({ work }, 'work');
  }

  /** Shows how the job goes, then what became of it. */
  private async watch(begun: Job, side: Side, signal: AbortSignal): Promise<void> {
    let job = begun;
    let phases: string[] = [];
    const show = (fraction: number | undefined, detail: string): void =>
      this.work({ side, what: job.status === 'accepted' ? 'queue' : 'run', fraction, detail, job, phases });
    const place = () => (job.queue_position ? `${job.queue_position} before it in the queue` : 'next in the queue');
    if (side === 0) this.setLink(job.id);
    show(undefined, place());
    const ended = isEnded(job) ? job : await followJob(this.api, job.id, {
      state: (now) => {
        job = now;
        phases = [];
        if (job.status === 'accepted') show(undefined, place());
      },
      progress: (progress, phase) => {
        job = { ...job, status: 'running' };
        const words = phase.replaceAll(/[-_]/g, ' ');
        if (words !== '' && phases.at(-1) !== words) phases = [...phases, words];
        show(progress, words);
      },
      log: () => undefined,
      lost: (again) => {
        if (again > 0) show(this.state.work?.fraction, 'the connection to the server was lost; the job is safe there. Trying again …');
      },
    }, signal);
    if (!ended) return;
    void this.refreshHistory().catch(() => undefined);
    await this.finish(ended, side);
  }

  private async finish(job: Job, side: Side): Promise<void> {
    if (job.status === 'failed') {
      const error = job.error ? ApiError.of(job.error) : unreachable('the job failed without a reason');
      const parked = job.parked ? ' Its attempts are used up; Try again in the list of jobs starts it anew.' : '';
      throw new ApiError(error.code, error.title, error.detail, error.hint + parked, error.status, error.requestId);
    }
    if (job.status === 'dismissed') {
      this.change({ work: undefined, notice: 'The job was cancelled.' });
      return;
    }
    await this.show(job, side);
  }

  /** Opens a job by its id, whatever its state. */
  open(id: string, side: Side): Promise<void> {
    this.stop();
    const { signal } = this.abort;
    return this.guard(async () => {
      this.change({ error: undefined, notice: '' });
      const job = await this.api.job(id);
      await this.bringCloud(job, side);
      await this.watch(job, side, signal);
    });
  }

  /** The points of a job that was opened by its link, if this device has kept them. */
  private async bringCloud(job: Job, side: Side): Promise<void> {
    const { cloud } = this.state;
    if (side === 1 || (job.cloud_id && cloud?.id === job.cloud_id)) return;
    const file = job.cloud_id ? await keptCloud(job.cloud_id) : undefined;
    if (file) await this.setCloud(file);
    else this.change({ results: [undefined, undefined], difference: undefined, cloud: undefined });
    if (this.state.cloud) this.state.cloud.id = job.cloud_id ?? undefined;
    else if (job.cloud_id) this.change({ cloud: { name: `cloud ${job.cloud_id.slice(0, 8)}`, size: 0, id: job.cloud_id, noPreview: 'only the server has its points' } });
  }

  private async show(job: Job, side: Side): Promise<void> {
    this.work({ side, what: 'load', fraction: 0, detail: 'fetching the mesh', job });
    const progress = (fraction: number): void => this.work({ side, what: 'load', fraction, detail: 'fetching the mesh', job });
    const [glb, report] = await Promise.all([this.api.bytes(`v1/jobs/${job.id}/outputs/mesh.glb`, progress), this.api.report(job.id)]);
    this.work({ side, what: 'load', detail: 'measuring the mesh', job });
    const mesh = await this.geometry.loadMesh(glb);
    const results: State['results'] = [...this.state.results];
    const before = results[side];
    results[side] = { job, report, mesh };
    if (before) void this.geometry.forget(before.mesh.handle);
    const colour = this.state.colour === 'difference' ? 'none' : this.state.colour;
    this.change({ results, difference: undefined, pointed: undefined, work: undefined, colour, look: { ...this.state.look, points: false } });
    this.setLinks();
    await this.complete();
  }

  /** Measures what the present look needs and has not yet. */
  async complete(): Promise<void> {
    const { cloud, results, look, colour } = this.state;
    for (const result of results) {
      if (!result) continue;
      const { mesh } = result;
      if (cloud?.data && look.marks && !result.unused && (result.report.quality.unused_points ?? 1) > 0) {
        result.unused = await this.geometry.unused(mesh.handle, cloud.data.handle, result.report.mesh.closed);
        this.change({}, 'view');
      }
      if (look.wireframe && !result.wireframe) {
        result.wireframe = await this.geometry.wireframe(mesh.handle);
        this.change({}, 'view');
      }
      if (colour === 'distance' && cloud?.data && !result.distances) {
        result.distances = await this.geometry.distances(mesh.handle, cloud.data.handle);
        this.change({}, 'view');
      }
    }
    const [first, second] = this.state.results;
    if (colour === 'difference' && first && second && !this.state.difference) {
      this.change({ notice: 'Measuring the difference …' });
      this.change({ difference: await this.geometry.difference(first.mesh.handle, second.mesh.handle), notice: '' });
    }
  }

  setLook(look: Partial<State['look']>): void {
    this.change({ look: { ...this.state.look, ...look } }, 'view');
    void this.guard(() => this.complete());
  }

  setColour(colour: ColourBy): void {
    this.change({ colour });
    void this.guard(() => this.complete());
  }

  async cancel(): Promise<void> {
    const job = this.state.work?.job;
    this.stop();
    this.change({ work: undefined, notice: 'Cancelled.' });
    if (job && !isEnded(job)) await this.guard(async () => void (await this.api.cancel(job.id)));
    await this.refreshHistory().catch(() => undefined);
  }

  async retry(id: string): Promise<void> {
    await this.guard(async () => {
      await this.api.retry(id);
      await this.open(id, 0);
    });
  }

  closeSecond(): void {
    const [first, second] = this.state.results;
    if (second) void this.geometry.forget(second.mesh.handle);
    this.change({ results: [first, undefined], difference: undefined, colour: this.state.colour === 'difference' ? 'none' : this.state.colour });
    this.setLinks();
  }

  private stop(): void {
    this.abort.abort(new Error('something else was begun'));
    this.abort = new AbortController();
    this.change({ work: undefined }, 'work');
  }

  private forget(): void {
    const { cloud, results } = this.state;
    for (const handle of [cloud?.data?.handle, ...results.map((result: Result | undefined) => result?.mesh.handle)]) {
      if (handle !== undefined) void this.geometry.forget(handle);
    }
  }

  private setLink(job: string): void {
    history.replaceState(null, '', `?job=${job}`);
  }

  private setLinks(): void {
    const [first, second] = this.state.results;
    if (first) history.replaceState(null, '', `?job=${first.job.id}${second ? `&with=${second.job.id}` : ''}`);
  }
}
