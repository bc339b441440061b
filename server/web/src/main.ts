// SPDX-License-Identifier: GPL-3.0-or-later
import {Api, ApiError} from './api/client';
import {contentsOf, describeView} from './app/contents';
import {keepPicture} from './app/pictures';
import {Session} from './app/session';

import type {State} from './app/state';
import {whenChanged} from './ui/changed';
import {acceptDrops, mountCloudPanel} from './ui/cloud_panel';
import {fill, h, must} from './ui/dom';
import {mountCompass} from './ui/compass';
import {mountHistoryPanel} from './ui/history_panel';
import {mountMethodPanel} from './ui/method_panel';
import {mountOverlay} from './ui/overlay';
import {mountResultPanel} from './ui/result_panel';
import {mountTitle} from './ui/title';
import {listenToKeys, mountToolbar} from './ui/toolbar';
import {mountTopBar} from './ui/top_bar';
import {mountTools} from './ui/tools';
import {mountWorkPanel, mountErrors} from './ui/work_panel';
import {Stage} from './view/stage';
import {language} from './words/language';
import {t} from './words/words';
import {startGeometry} from './worker/geometry';

/** Without WebGL everything works but the picture. */
function startStage(session: Session, canvas: HTMLCanvasElement): Stage|undefined {
  try {
    return new Stage(canvas);
  } catch (failure) {
    canvas.hidden = true;
    const detail = failure instanceof Error ? failure.message : String(failure);
    session.change({blind: true, error: new ApiError('no_webgl', t.errors.noWebgl, detail, t.errors.noWebglHint)});
    return undefined;
  }
}

/** All that the picture is made of. */
function picture({cloud, results, difference, pointed, look, clip, colour, up, theme}: State): unknown[] {
  return [
    cloud, cloud?.data, difference, pointed, look, clip.axis, colour, up, theme,
    ...results.flatMap((result) => [result, result?.unused, result?.wireframe, result?.distances])
  ];
}

function showOn(stage: Stage, session: Session, canvas: HTMLCanvasElement): void {
  let shown: unknown;
  let up: State['up'] = 'y';
  let panes = 1;
  let pictured: string|undefined;
  session.onChange(whenChanged(picture, (state) => {
    const contents = contentsOf(state);
    const [first, second] = state.results;
    stage.setPanes(contents, {...state.look, points: state.look.points || !first}, state.clip, state.theme);
    canvas.setAttribute('aria-label', describeView(state));
    // A new cloud is looked at as a whole; a new mesh over it from where one stands.
    const subject = state.cloud?.data ?? first?.mesh;
    if ((subject && subject !== shown) || state.up !== up || contents.length !== panes) {
      stage.fit(state.up);
      if (subject) shown = subject;
      up = state.up;
      panes = contents.length;
    }
    if (!first || second || first.job.id === pictured) return;
    pictured = first.job.id;
    keepPicture(pictured, stage.snapshot());
    session.change({pictures: state.pictures + 1}, 'view');
  }));
  stage.onSlow = () => {
    if (!session.state.look.shade) return;
    session.change({notice: t.view.softly});
    session.setLook({shade: false});
  };
}

function namePlaces(): void {
  document.documentElement.lang = language;
  must<HTMLElement>('.skip').textContent = t.top.skip;
  must<HTMLMetaElement>('meta[name="description"]').content = t.top.description;
  for (const [place, name] of [['#setup', t.top.setup], ['#view', t.top.view], ['#results', t.top.result]] as const)
    must(place).setAttribute('aria-label', name);
}

function start(): void {
  namePlaces();
  const session = new Session(new Api(), startGeometry());
  const panel = (): HTMLElement => h('section', {class: 'panel'});
  const [cloud, method, work, jobs] = [panel(), panel(), panel(), panel()];
  work.id = 'work';
  fill(must('#setup'), cloud, method, work, jobs);
  mountTitle(session);
  mountTopBar(must('#top'), session);
  mountCloudPanel(cloud, session);
  mountMethodPanel(method, session);
  mountWorkPanel(work, session);
  mountHistoryPanel(jobs, session);
  mountOverlay(must('#overlay'), session);
  mountErrors(must('#message'), session);
  acceptDrops(session);
  const canvas = must<HTMLCanvasElement>('#canvas');
  const stage = startStage(session, canvas);
  mountResultPanel(must('#results'), session, stage);
  if (stage) {
    const toolbar = h('div', {class: 'toolbar', role: 'toolbar', 'aria-label': t.view.toolbar});
    const tools = h('div', {class: 'tools', role: 'group', 'aria-label': t.view.tools});
    const compass = h('div', {class: 'compass'});
    must('#view').append(tools, toolbar, compass);
    showOn(stage, session, canvas);
    mountToolbar(toolbar, session);
    mountTools(tools, session, stage);
    mountCompass(compass, session, stage);
    listenToKeys(session, stage);
    Object.assign(window, {surfacedStage: stage});
  }
  void session.start();
}

start();
