// SPDX-License-Identifier: GPL-3.0-or-later
// What the page does: choose a cloud, run methods on it, open and compare jobs. Panels call it and are told of changes.
import {ApiError, unreachable, type Api} from '../api/client';
import {isEnded, type Job, type Sample} from '../api/types';
import type {TableOptions} from '../clouds/table';
import {count} from '../words/numbers';
import {t} from '../words/words';
import type {Geometry} from '../worker/geometry';
import {onLink, readLink, writeLink, type Link} from './address';
import {followWork} from './following';
import {cloudOfJob} from './job_cloud';
import {complete} from './measuring';
import {dropPicture} from './pictures';
import {sendCloud, sendJob, submissionOf} from './sending';
import {initialState, type ChosenCloud, type ColourBy, type Result, type Run, type Side, type State, type Work} from './state';

export type What = 'all'|'view'|'work';

const kTableOptions = ['columns', 'separator', 'decimal', 'skip'];
export class Session {
  readonly state: State = initialState();
  private readonly listeners: ((state: State, what: What) => void)[] = [];
  /** Of what was begun last. Each has its own signal, and whatever comes after that is aborted changes nothing. */
  private abort = new AbortController();
  /** Whether z is up because of the cloud, and not because somebody said so. */
  private turned = false;
  /** What the address named when the page was opened, until it is opened or something else is begun. */
  private link: Link|undefined = readLink();

  constructor(readonly api: Api, readonly geometry: Geometry) {
    onLink((link) => void this.follow(link));
  }

  onChange(listener: (state: State, what: What) => void): void {
    this.listeners.push(listener);
  }

  change(part: Partial<State>, what: What = 'all'): void {
    Object.assign(this.state, part);
    for (const listener of this.listeners) listener(this.state, what);
  }

  async start(): Promise<void> {
    await this.guard(async () => {
      const [methods, samples] = await Promise.all([this.api.methods(), this.api.samples()]);
      this.change({methods, samples});
      await this.refreshHistory();
      if (this.link?.job) await this.follow(this.link);
    });
  }

  /** Shows what an address names: jobs, or the page as it is before any. */
  private follow({job, other}: Link): Promise<void> {
    return this.begin(async (signal) => {
      if (!job) {
        this.clear();
        return;
      }
      const [first, second] = this.state.results;
      if (first?.job.id === job && !other)
        this.drop(second);
      else if (first?.job.id !== job)
        await this.bring(job, 0, signal);
      if (other && this.state.results[0]) await this.bring(other, 1, signal);
    });
  }

  private clear(): void {
    for (const result of this.state.results) this.letGo(result?.mesh.handle);
    this.change(
        {results: [undefined, undefined], difference: undefined, pointed: undefined, error: undefined, notice: ''});
  }

  /** Ends what was begun before, and runs something under a signal of its own. */
  begin(task: (signal: AbortSignal) => Promise<void>): Promise<void> {
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
      const detail = failure instanceof Error ? failure.message : String(failure);
      const error =
          failure instanceof ApiError ? failure : new ApiError('page', t.errors.page, detail, t.errors.reload);
      const needsKey = this.state.needsKey || error.code === 'unauthorized';
      this.change({error, notice: '', ...(signal && {work: undefined}), needsKey});
    }
  }

  async useKey(key: string): Promise<void> {
    this.api.key = key.trim();
    this.change({needsKey: true, error: undefined});
    await this.guard(() => this.refreshHistory());
    if (this.state.error) return;
    this.change({notice: t.work.keyAccepted});
    if (this.link?.job) await this.follow(this.link);
  }

  async refreshHistory(): Promise<void> {
    this.change({history: await this.api.jobs(50)});
  }

  chooseSample(sample: Sample): Promise<void> {
    return this.begin(async (signal) => {
      this.change({error: undefined, notice: t.cloud.fetching(sample.name)});
      const body = await this.api.bytes(`samples/${encodeURIComponent(sample.name)}`, () => undefined, signal);
      signal.throwIfAborted();
      const {methods: [usual], run} = this.state;
      const method = sample.method ?? usual?.id;
      if (run && method && method !== run.method) this.setRun({method, parameters: {}});
      await this.chooseFile(new File([body], sample.name));
    });
  }

  /** One is shown; of several it is asked what becomes of them. */
  chooseFiles(files: File[]): Promise<void> {
    if (files.length < 2) return files[0] ? this.chooseFile(files[0]) : Promise.resolve();
    this.change({dropped: files, error: undefined});
    return Promise.resolve();
  }

  chooseFile(file: File): Promise<void> {
    return this.begin(async () => {
      writeLink({});
      await this.setCloud(file);
    });
  }

  private replaceCloud(cloud: ChosenCloud|undefined, notice: string): void {
    const {results} = this.state;
    for (const handle of [this.state.cloud?.data?.handle, ...results.map((result) => result?.mesh.handle)])
      this.letGo(handle);
    this.change({
      cloud,
      notice,
      dropped: [],
      results: [undefined, undefined],
      difference: undefined,
      pointed: undefined,
      error: undefined,
      colour: 'none',
      look: {...this.state.look, points: true},
    });
  }

  /** What is begun meanwhile does not end the reading, another cloud does. */
  async setCloud(file: File, id?: string, whole?: ChosenCloud): Promise<void> {
    const cloud: ChosenCloud = {name: file.name, size: file.size, file, id, whole};
    this.replaceCloud(cloud, t.cloud.reading(file.name));
    if (file.size > 0) await this.readCloud(cloud, file);
    if (this.state.cloud !== cloud) return this.letGo(cloud.data?.handle);
    if (!id && !whole) this.turn(cloud.data?.zUp === true);
    this.change({notice: '', ...(cloud.data?.colours && {colour: 'own'})});
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
    if (stale) return this.letGo(data?.handle);
    Object.assign(cloud, {data, noPreview});
    this.letGo(before?.handle);
  }

  /** What the form says. A text is read again, and the picture turned, as it says. */
  setRun(run: Run): void {
    const {up = 'y'} = run.parameters as {up?: State['up']};
    this.change({run, up}, 'view');
    const given = Object.entries(run.parameters).filter(([name]) => kTableOptions.includes(name));
    this.setTable(Object.fromEntries(given) as TableOptions);
  }

  /** A survey starts with z up; what was turned for one is turned back for another cloud. */
  private turn(zUp: boolean): void {
    if (zUp && this.state.up === 'y')
      this.setUp('z');
    else if (!zUp && this.turned)
      this.setUp('y');
    this.turned = zUp;
  }

  setUp(up: State['up']): void {
    const {run} = this.state;
    if (!run) return this.change({up}, 'view');
    const {up: _, ...others} = run.parameters;
    this.setRun({...run, parameters: up === 'y' ? others : {...others, up}});
  }

  /** Says how a text is to be read; the chosen one is read again. */
  private setTable(table: TableOptions): void {
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
      if (!cloud) throw new ApiError('page', t.errors.noCloud, t.errors.noCloudDetail, t.errors.noCloudHint);
      this.change({error: undefined, notice: ''});
      cloud.id ??= await this.upload(cloud, side, signal);
      this.work({side, what: 'submit', detail: t.work.handing}, signal);
      try {
        const job = await sendJob(this.api, submissionOf(cloud.id, cloud.name, run.method, run.parameters), signal);
        await this.watch(job, side, signal);
      } catch (failure) {
        if (failure instanceof ApiError && failure.code === 'cloud_not_found') cloud.id = undefined;
        // A job that was queued after its page had turned to something else is cancelled.
        if (signal.aborted) void this.refreshHistory().catch(() => undefined);
        throw failure;
      }
    });
  }

  private async upload({file}: ChosenCloud, side: Side, signal: AbortSignal): Promise<string> {
    const {errors} = t;
    if (!file) throw new ApiError('page', errors.notHere, errors.notHereDetail, errors.notHereHint);
    if (file.size === 0)
      throw new ApiError('empty_input', errors.emptyFile, errors.emptyFileDetail, t.errors.noCloudHint);
    const told = (fraction: number|undefined, detail: string): void =>
        this.work({side, what: 'upload', fraction, detail}, signal);
    const id = await sendCloud(this.api, file, told, signal);
    signal.throwIfAborted();
    return id;
  }

  work(work: Work, signal: AbortSignal): void {
    if (!signal.aborted) this.change({work}, 'work');
  }

  /** Shows how the job goes, then what became of it. */
  private async watch(begun: Job, side: Side, signal: AbortSignal): Promise<void> {
    if (side === 0) writeLink({job: begun.id});
    const ended = await followWork(this.api, begun, (work) => this.work({side, ...work}, signal), signal);
    signal.throwIfAborted();
    if (!ended) return;
    void this.refreshHistory().catch(() => undefined);
    await this.finish(ended, side, signal);
  }

  private async finish(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    if (job.status === 'failed') {
      const error = job.error ? ApiError.of(job.error) : unreachable(t.errors.noReason);
      const parked = job.parked ? t.errors.parked : '';
      throw new ApiError(
          error.code, error.title, error.detail, error.hint + parked, error.status, error.requestId, error.field);
    }
    if (job.status === 'dismissed')
      this.change({work: undefined, notice: t.work.jobCancelled});
    else
      await this.show(job, side, signal);
  }

  /** Opens a job by its id, whatever its state. */
  open = (id: string, side: Side): Promise<void> => this.begin((signal) => this.bring(id, side, signal));

  private async bring(id: string, side: Side, signal: AbortSignal): Promise<void> {
    this.change({error: undefined, notice: ''});
    const job = await this.api.job(id, signal);
    signal.throwIfAborted();
    await this.bringCloud(job, side, signal);
    if (side === 0) this.setRun({method: job.method, parameters: job.parameters});
    await this.watch(job, side, signal);
  }

  private async bringCloud(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    if (side === 1 || (job.cloud_id && this.state.cloud?.id === job.cloud_id)) return;
    const cloud = await cloudOfJob(this.api, job);
    signal.throwIfAborted();
    if (cloud?.file)
      await this.setCloud(cloud.file, cloud.id);
    else
      this.replaceCloud(cloud, '');
    signal.throwIfAborted();
  }

  private async show(job: Job, side: Side, signal: AbortSignal): Promise<void> {
    const progress = (fraction: number): void =>
        this.work({side, what: 'load', fraction, detail: t.work.fetching, job}, signal);
    progress(0);
    const [glb, report] = await Promise.all([
      this.api.bytes(`v1/jobs/${job.id}/outputs/mesh.glb`, progress, signal),
      this.api.report(job.id, signal),
    ]);
    signal.throwIfAborted();
    this.work({side, what: 'load', detail: t.work.measuring, job}, signal);
    const mesh = await this.geometry.loadMesh(glb);
    if (signal.aborted) this.letGo(mesh.handle);
    signal.throwIfAborted();
    const results: State['results'] = [...this.state.results];
    this.letGo(results[side]?.mesh.handle);
    results[side] = {job, report, mesh};
    const notice = t.work.done(count(report.mesh.triangles), report.mesh.closed);
    const {colour, look} = this.state;
    const own = mesh.colours ? 'own' : 'none';
    this.setLinks(results);
    this.change({
      results,
      notice,
      difference: undefined,
      pointed: undefined,
      work: undefined,
      look: {...look, points: false},
      colour: colour === 'difference' || colour === 'none' || colour === 'own' ? own : colour,
    });
    await this.complete();
  }

  private complete = (): Promise<void> => complete(this.geometry, this.state, (part, what) => this.change(part, what));

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
    this.change({work: undefined, notice: t.work.cancelled});
    if (job && !isEnded(job)) await this.guard(async () => void (await this.api.cancel(job.id)));
    await this.refreshHistory().catch(() => undefined);
  }

  /** Deletes a job that has ended, with its files. */
  remove(id: string): Promise<void> {
    return this.guard(async () => {
      await this.api.remove(id);
      dropPicture(id);
      this.change({notice: t.jobs.removed});
      await this.refreshHistory();
    });
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
    this.setLinks([first, undefined]);
    this.drop(second);
  }

  private drop(second: Result|undefined): void {
    this.letGo(second?.mesh.handle);
    const {results: [first], colour} = this.state;
    this.change({
      results: [first, undefined],
      difference: undefined,
      notice: '',
      colour: colour === 'difference' ? 'none' : colour
    });
  }

  private stop(): void {
    this.abort.abort(new Error('something else was begun'));
    this.abort = new AbortController();
    this.link = undefined;
    this.change({work: undefined}, 'work');
  }

  private letGo(handle: number|undefined): void {
    if (handle !== undefined) void this.geometry.forget(handle);
  }

  /** Before the results are shown, because the panel shows the link too. */
  private setLinks = ([first, second]: State['results']): void =>
      writeLink({job: first?.job.id, other: second?.job.id});
}
