// SPDX-License-Identifier: GPL-3.0-or-later
// The canvas: one or two panes under one camera, drawn only when something has changed.
import {Box3, Color, DirectionalLight, Group, HemisphereLight, Matrix4, PerspectiveCamera, Plane, Scene, Vector2, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {Layers, type Content, type Look} from './layers';
import {palettes, type Palette} from './materials';
import {pickPoint, pickTriangle, type Picked} from './picking';
import {DepthShading} from './shading';

export interface Clip {
  axis: 'none'|'x'|'y'|'z';
  /** 0 to 1 through the box. */
  place: number;
  flip: boolean;
}

/** Drawing rests this long after the camera has stopped before the whole mesh is drawn again. */
const kRest = 180;
/** A machine that takes longer for the shaded picture, in milliseconds, draws the next ones without. */
const kSlow = 700;

interface Pane {
  scene: Scene;
  root: Group;
  layers: Layers;
  content: Content;
}

/** What draws without a graphics card is told by its name. */
function drawsInSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) throw new Error('WebGL 2 is not available');
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Stage {
  private readonly renderer: WebGLRenderer;
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100);
  private controls: OrbitControls;
  private readonly panes: Pane[] = [];
  private readonly plane = new Plane(new Vector3(-1, 0, 0), 0);
  private palette: Palette = palettes.light;
  private origin: [number, number, number] = [0, 0, 0];
  private readonly box = new Box3();
  private readonly shading: DepthShading;
  private readonly software: boolean;
  private shaded = true;
  private slowFrames = 0;
  private planes: Plane[] = [];
  private waiting = 0;
  private resting = 0;
  private moving = false;
  /** Told after each frame; for measuring. */
  onFrame: ((milliseconds: number) => void)|undefined;
  /** Told after each frame, too: where the camera is may have changed. */
  onView: (() => void)|undefined;
  /** Told when the machine is too slow for shading. */
  onSlow: (() => void)|undefined;

  constructor(readonly canvas: HTMLCanvasElement) {
    const software = drawsInSoftware();
    this.software = software;
    this.renderer = new WebGLRenderer({canvas, antialias: !software, powerPreference: 'high-performance'});
    this.renderer.setPixelRatio(software ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.renderer.localClippingEnabled = true;
    this.shading = new DepthShading(this.renderer, software ? 0 : 4);
    this.camera.position.set(1.3, 0.8, 2.4);
    this.controls = this.newControls();
    new ResizeObserver(() => this.resize()).observe(canvas);
    canvas.addEventListener('webglcontextrestored', () => this.draw());
  }

  setPanes(contents: Content[], look: Look, clip: Clip, theme: 'light'|'dark'): void {
    this.palette = palettes[theme];
    this.shaded = look.shade;
    while (this.panes.length > contents.length) this.panes.pop()?.layers.dispose();
    while (this.panes.length < contents.length) this.panes.push(this.newPane());
    const first = contents.find((content) => content.mesh ?? content.cloud);
    this.origin = first?.mesh?.origin ?? first?.cloud?.origin ?? [0, 0, 0];
    this.planes = clip.axis === 'none' ? [] : [this.plane];
    const setting = {look, palette: this.palette, planes: this.planes, origin: this.origin};
    contents.forEach((content, i) => {
      const pane = this.panes[i];
      pane.content = content;
      pane.scene.background = new Color(this.palette.background);
      pane.layers.show(content, setting);
    });
    this.normalise(contents);
    this.setClip(clip);
    this.draw();
  }

  /** Whatever its size, what is shown gets the size of about 1 around the middle. */
  private normalise(contents: Content[]): void {
    this.box.makeEmpty();
    const p = new Vector3();
    for (const {cloud, mesh} of contents) {
      for (const part of [mesh, cloud]) {
        for (let i = 0; part && i < part.positions.length; i += 3) {
          p.set(
              part.positions[i] + part.origin[0] - this.origin[0],
              part.positions[i + 1] + part.origin[1] - this.origin[1],
              part.positions[i + 2] + part.origin[2] - this.origin[2]);
          this.box.expandByPoint(p);
        }
        if (part) break;
      }
    }
    if (this.box.isEmpty()) return;
    const scale = 2 / (this.box.getSize(new Vector3()).length() || 1);
    const middle = this.box.getCenter(new Vector3());
    for (const {root} of this.panes) {
      root.scale.setScalar(scale);
      root.position.copy(middle).multiplyScalar(-scale);
    }
  }

  setClip({axis, place, flip}: Clip): void {
    if (axis === 'none' || this.box.isEmpty()) return;
    const side = flip ? 1 : -1;
    const normal = new Vector3(axis === 'x' ? side : 0, axis === 'y' ? side : 0, axis === 'z' ? side : 0);
    const at = new Vector3().lerpVectors(this.box.min, this.box.max, place);
    const {root} = this.panes[0];
    this.plane.setFromNormalAndCoplanarPoint(normal, at.multiplyScalar(root.scale.x).add(root.position));
    this.draw();
  }

  /** Up along y or z, and the whole in view. */
  fit(up: 'y'|'z' = this.camera.up.z === 1 ? 'z' : 'y'): void {
    this.camera.up.set(0, up === 'y' ? 1 : 0, up === 'z' ? 1 : 0);
    const aspect = Math.min(1, this.aspect());
    const distance = 1.06 / Math.sin((this.camera.fov * Math.PI) / 360) / (aspect ** 0.9);
    const direction = up === 'y' ? new Vector3(0.45, 0.3, 1) : new Vector3(0.45, -1, 0.35);
    this.camera.position.copy(direction.setLength(distance));
    // Controls keep the axis they were made with.
    this.controls.dispose();
    this.controls = this.newControls();
    this.controls.update();
    this.draw();
  }

  /** A small picture of what is shown now. */
  snapshot(): string {
    const small = document.createElement('canvas');
    [small.width, small.height] = [128, 96];
    const {width, height} = this.canvas;
    const side = Math.min(width / 4, height / 3);
    this.drawNow();
    small.getContext('2d')?.drawImage(
        this.canvas, (width - 4 * side) / 2, (height - 3 * side) / 2, 4 * side, 3 * side, 0, 0, 128, 96);
    return small.toDataURL('image/jpeg', 0.8);
  }

  private newControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.addEventListener('change', () => this.moved());
    return controls;
  }

  /** Looks at a triangle from outside, so close that it fills a good part of the view. */
  flyTo(corners: [number, number, number][]): void {
    const {root} = this.panes[0];
    const [a, b, c] = corners.map((p) => new Vector3(...p).multiplyScalar(root.scale.x).add(root.position));
    const middle = new Vector3().add(a).add(b).add(c).divideScalar(3);
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    if (normal.lengthSq() < 1e-24) normal.copy(this.camera.position).sub(middle);
    const size = Math.max(a.distanceTo(b), b.distanceTo(c), c.distanceTo(a));
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(normal.setLength(Math.max(0.05, 6 * size)));
    this.controls.update();
    this.draw();
  }

  /** Looks along an axis, from its positive end or its negative one. */
  lookAlong(axis: 'x'|'y'|'z', positive: boolean): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const direction = new Vector3();
    direction[axis] = positive ? 1 : -1;
    // Along up itself the controls could not tell which way is up on the screen.
    if (Math.abs(direction.dot(this.camera.up)) > 0.99)
      direction.add(this.camera.up.z === 1 ? new Vector3(0, -1e-3, 0) : new Vector3(0, 0, 1e-3));
    this.camera.position.copy(this.controls.target).add(direction.setLength(distance));
    this.controls.update();
    this.draw();
  }

  /** The axes on the screen: right, up and towards the eye, each -1 to 1. */
  axesOnScreen(): Record<'x'|'y'|'z', Vector3> {
    const turned = this.camera.quaternion.clone().invert();
    const of = (x: number, y: number, z: number) => new Vector3(x, y, z).applyQuaternion(turned);
    return {x: of(1, 0, 0), y: of(0, 1, 0), z: of(0, 0, 1)};
  }

  /** So long in the units of the file is a pixel where the camera looks; 0 if nothing is shown. */
  unitsOfPixel(): number {
    if (this.box.isEmpty() || !this.panes[0]) return 0;
    const distance = this.camera.position.distanceTo(this.controls.target);
    const height = 2 * Math.tan((this.camera.fov * Math.PI) / 360) * distance;
    return height / Math.max(1, this.canvas.clientHeight) / this.panes[0].root.scale.x;
  }

  /** What is under a place of the canvas, in the first pane; its coordinates are those of the file. */
  pick(x: number, y: number): Picked|undefined {
    const pixels = new Vector2(this.canvas.clientWidth / Math.max(1, this.panes.length), this.canvas.clientHeight);
    const pane = this.panes[0];
    if (!pane || x > pixels.x) return undefined;
    const at = new Vector2((2 * x) / pixels.x - 1, 1 - (2 * y) / pixels.y);
    const {cloud, mesh} = pane.content;
    if (mesh) return pickTriangle(pane.layers.group, this.camera, at, this.planes);
    if (!cloud) return undefined;
    const offset = cloud.origin.map((value, k) => value - this.origin[k]) as [number, number, number];
    const matrix = pane.root.matrixWorld.clone().multiply(new Matrix4().makeTranslation(...offset));
    return pickPoint(cloud.positions, matrix, this.camera, at, pixels, this.planes);
  }

  orbit(right: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.camera.up, -right);
    const side = new Vector3().crossVectors(this.camera.up, offset).normalize();
    const tilted = offset.clone().applyAxisAngle(side, -up);
    if (Math.abs(tilted.clone().normalize().dot(this.camera.up)) < 0.99) offset.copy(tilted);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.moved();
  }

  zoom(factor: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.moved();
  }

  private newPane(): Pane {
    const pane: Pane = {scene: new Scene(), root: new Group(), layers: new Layers(), content: {}};
    pane.root.add(pane.layers.group);
    // The lights go with the camera; layers of the scene graph are cheap enough to have them twice.
    const key = new DirectionalLight('#ffffff', 1.9);
    pane.scene.add(pane.root, new HemisphereLight('#eef4fa', '#b9a892', 0.95), key, key.target);
    pane.scene.userData.key = key;
    return pane;
  }

  private moved(): void {
    if (!this.moving) this.panes.forEach(({layers}) => layers.moving(true));
    this.moving = true;
    clearTimeout(this.resting);
    this.resting = window.setTimeout(() => {
      this.moving = false;
      this.panes.forEach(({layers}) => layers.moving(false));
      this.draw();
    }, kRest);
    this.draw();
  }

  private aspect(): number {
    return this.canvas.clientWidth / Math.max(1, this.panes.length) / Math.max(1, this.canvas.clientHeight);
  }

  private resize(): void {
    this.renderer.setSize(this.canvas.clientWidth, this.canvas.clientHeight, false);
    this.drawNow();
  }

  /** Whether something is still to be drawn: the camera moves, or has just stopped. */
  get busy(): boolean {
    return this.moving || this.waiting !== 0;
  }

  draw(): void {
    this.waiting ||= requestAnimationFrame(() => this.drawNow());
  }

  private drawNow(): void {
    cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    const began = performance.now();
    const width = this.canvas.clientWidth / Math.max(1, this.panes.length);
    const height = this.canvas.clientHeight;
    if (width < 1 || height < 1) return;
    this.camera.aspect = width / height;
    this.updateDepth();
    // Without a card the picture is shaded once it rests.
    if (this.shaded && !(this.software && this.moving))
      this.drawShaded(width, height);
    else
      this.drawPanes(width, height);
    this.onFrame?.(performance.now() - began);
    this.onView?.();
  }

  private drawPanes(width: number, height: number): void {
    this.renderer.setScissorTest(true);
    this.panes.forEach(({scene}, i) => {
      this.light(scene.userData.key as DirectionalLight);
      this.renderer.setViewport(i * width, 0, width, height);
      this.renderer.setScissor(i * width, 0, width, height);
      this.renderer.clear();
      this.renderer.render(scene, this.camera);
    });
  }

  private drawShaded(width: number, height: number): void {
    const began = performance.now();
    const {mesh, cloud} = this.panes[0]?.content ?? {};
    this.shading.render(this.camera, () => this.drawPanes(width, height));
    if (!this.software || !(mesh ?? cloud)) return;
    // To read a pixel waits for the picture.
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    if (performance.now() - began < kSlow)
      this.slowFrames = 0;
    else if (++this.slowFrames > 2)
      this.onSlow?.();
  }

  private updateDepth(): void {
    const distance = this.camera.position.length();
    this.camera.near =
        Math.max(distance - 1.5, Math.min(0.02, 0.05 * this.camera.position.distanceTo(this.controls.target)));
    this.camera.far = distance + 1.5;
    this.camera.updateProjectionMatrix();
  }

  /** From above the left shoulder. */
  private light(key: DirectionalLight): void {
    const offset = new Vector3(-0.5, 0.7, 1).applyQuaternion(this.camera.quaternion);
    key.position.copy(this.controls.target).add(offset);
    key.target.position.copy(this.controls.target);
  }
}
