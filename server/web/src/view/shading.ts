// SPDX-License-Identifier: GPL-3.0-or-later
// Shading by depth: what lies deeper than its surroundings is darkened, so that points without normals get a shape, and
// creases and outlines of a surface stand out. After Boucheny, Interactive scientific visualization of large datasets
// (2009), the eye-dome lighting of clouds of points; a second, wider ring of neighbours stands for ambient occlusion.
import {DepthTexture, HalfFloatType, Mesh, OrthographicCamera, PlaneGeometry, Scene, ShaderMaterial, UnsignedIntType, Vector2, WebGLRenderTarget, type PerspectiveCamera, type WebGLRenderer} from 'three';

const kVertex = `varying vec2 place;
void main() {
  place = uv;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

const kFragment = `uniform sampler2D picture;
uniform sampler2D depths;
uniform vec2 pixel;
uniform float near;
uniform float far;
uniform float strength;
varying vec2 place;

float distanceAt(vec2 at) {
  float z = texture2D(depths, at).x;
  return z >= 1.0 ? 0.0 : log2(near * far / (far - z * (far - near)));
}

float ring(float own, float radius) {
  float sum = 0.0;
  for (int i = 0; i < 8; i += 1) {
    float angle = 0.7853982 * float(i) + 0.3;
    float other = distanceAt(place + radius * pixel * vec2(cos(angle), sin(angle)));
    if (other != 0.0) sum += clamp(own - other, 0.0, 0.12);
  }
  return sum / 8.0;
}

void main() {
  vec4 colour = texture2D(picture, place);
  float own = distanceAt(place);
  if (own != 0.0 || texture2D(depths, place).x < 1.0) {
    float deeper = ring(own, 1.4) + 0.5 * ring(own, 6.0);
    colour.rgb *= mix(0.35, 1.0, exp(-strength * deeper));
  }
  gl_FragColor = colour;
  #include <colorspace_fragment>
}`;

/** The larger, the darker the same step of depth. */
const kStrength = 45;

export class DepthShading {
  private readonly target: WebGLRenderTarget;
  private readonly material: ShaderMaterial;
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
  private readonly plane: Mesh;

  /** @param samples a pixel; none on a machine that draws without a card. */
  constructor(private readonly renderer: WebGLRenderer, samples: number) {
    this.target = new WebGLRenderTarget(1, 1, {samples, type: HalfFloatType});
    this.target.depthTexture = new DepthTexture(1, 1, UnsignedIntType);
    const {texture: picture, depthTexture: depths} = this.target;
    this.material = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      depthTest: false,
      depthWrite: false,
      uniforms: {
        picture: {value: picture},
        depths: {value: depths},
        pixel: {value: new Vector2()},
        near: {value: 0},
        far: {value: 1},
        strength: {value: kStrength},
      },
    });
    this.plane = new Mesh(new PlaneGeometry(2, 2), this.material);
    this.plane.frustumCulled = false;
    this.scene.add(this.plane);
  }

  /** Draws what `draw` draws, shaded. */
  render(camera: PerspectiveCamera, draw: () => void): void {
    const size = this.renderer.getDrawingBufferSize(new Vector2());
    if (this.target.width !== size.x || this.target.height !== size.y) this.target.setSize(size.x, size.y);
    const {uniforms} = this.material;
    uniforms.pixel.value.set(1 / size.x, 1 / size.y);
    uniforms.near.value = camera.near;
    uniforms.far.value = camera.far;
    this.renderer.setRenderTarget(this.target);
    draw();
    this.renderer.setRenderTarget(null);
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, size.x / this.renderer.getPixelRatio(), size.y / this.renderer.getPixelRatio());
    this.renderer.render(this.scene, this.camera);
  }

  dispose(): void {
    this.target.dispose();
    this.material.dispose();
    this.plane.geometry.dispose();
  }
}
