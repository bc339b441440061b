// SPDX-License-Identifier: GPL-3.0-or-later
// Shows a GLB in an element of a page, to be turned with the mouse or a finger.
import { Box3, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Sphere, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

/** What is shown in an element, to be let go before the next. */
const shown = new WeakMap();

/** @param glb  an ArrayBuffer. A mesh that was shown before is replaced. */
export async function show(element, glb) {
  const { scene: model } = await new GLTFLoader().parseAsync(glb, '');
  const { center, radius } = new Box3().setFromObject(model).getBoundingSphere(new Sphere());
  const scene = new Scene();
  scene.background = new Color(0xf4f4f2);
  const camera = new PerspectiveCamera(40, element.clientWidth / element.clientHeight, radius / 100, 20 * radius);
  camera.position.copy(center).add({ x: 0, y: 0.5 * radius, z: 3 * radius });
  const sun = new DirectionalLight(0xffffff, 1.4);
  camera.add(sun);
  scene.add(model, camera, new HemisphereLight(0xffffff, 0x777777, 0.9));

  const renderer = new WebGLRenderer({ antialias: true });
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setSize(element.clientWidth, element.clientHeight);
  shown.get(element)?.();
  element.replaceChildren(renderer.domElement);
  const draw = () => renderer.render(scene, camera);
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.target.copy(center);
  controls.addEventListener('change', draw);
  controls.update();
  const observer = new ResizeObserver(() => {
    camera.aspect = element.clientWidth / element.clientHeight;
    camera.updateProjectionMatrix();
    renderer.setSize(element.clientWidth, element.clientHeight);
    draw();
  });
  observer.observe(element);
  shown.set(element, () => {
    observer.disconnect();
    controls.dispose();
    renderer.dispose();
    renderer.forceContextLoss();
  });
  draw();
}
