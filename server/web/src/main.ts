// SPDX-License-Identifier: GPL-3.0-or-later
import {Api, ApiError} from './api/client';
import {Session} from './app/session';

import type {State} from './app/state';
import {whenChanged} from './ui/changed';
import {acceptDrops, mountCloudPanel} from './ui/cloud_panel';
import {fill, h, must} from './ui/dom';
import {mountHistoryPanel} from './ui/history_panel';
import {mountMethodPanel} from './ui/method_panel';
import {describeView, mountOverlay} from './ui/overlay';
import {mountResultPanel} from './ui/result_panel';
import {listenToKeys, mountToolbar} from './ui/toolbar';
import {mountTopBar} from './ui/top_bar';
import {mountWorkPanel} from './ui/work_panel';
import {contentsOf} from './view/contents';
import {Stage} from './view/stage';
import {startGeometry} from './worker/geometry';

/** Without WebGL everything works but the picture. */
function startStage(session: Session, canvas: HTMLCanvasElement): Stage|undefined {
  try {
    return new Stage(canvas);
  } catch (failure) {
    canvas.hidden = true;
    const detail = failure instanceof Error ? failure.message : String(failure);
    session.change({
      error: new ApiError(
          'no_webgl', 'This browser does not draw in 3D', detail,
          'Reconstruction, report and downloads work; for the picture, switch on WebGL 2 or hardware acceleration.')
    });
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
  session.onChange(whenChanged(picture, (state) => {
    const contents = contentsOf(state);
    stage.setPanes(contents, {...state.look, points: state.look.points || !state.results[0]}, state.clip, state.theme);
    canvas.setAttribute('aria-label', describeView(state));
    // A new cloud is looked at as a whole; a new mesh over it from where one stands.
    const subject = state.cloud?.data ?? state.results[0]?.mesh;
    if ((subject && subject !== shown) || state.up !== up || contents.length !== panes) {
      stage.fit(state.up);
      if (subject) shown = subject;
      up = state.up;
      panes = contents.length;
    }
  }));
}

function start(): void {
  const session = new Session(new Api(), startGeometry());
  const panel = (): HTMLElement => h('section', {class: 'panel'});
  const [cloud, method, work, jobs] = [panel(), panel(), panel(), panel()];
  work.id = 'work';
  fill(must('#setup'), cloud, method, work, jobs);
  mountTopBar(must('#top'), session);
  mountCloudPanel(cloud, session);
  mountMethodPanel(method, session);
  mountWorkPanel(work, session);
  mountHistoryPanel(jobs, session);
  mountOverlay(must('#overlay'), session);
  acceptDrops(session);
  const canvas = must<HTMLCanvasElement>('#canvas');
  const stage = startStage(session, canvas);
  mountResultPanel(must('#results'), session, stage);
  if (stage) {
    const toolbar = h('div', {class: 'toolbar', role: 'toolbar', 'aria-label': 'View'});
    must('#view').append(toolbar);
    showOn(stage, session, canvas);
    mountToolbar(toolbar, session, stage);
    listenToKeys(session, stage);
    Object.assign(window, {surfacedStage: stage});
  }
  void session.start();
}

start();
