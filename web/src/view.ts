// Picture of the data by vtk.js. It is drawn when the view or the data change, not by each moment of the hand.

import '@kitware/vtk.js/Rendering/OpenGL/Profiles/Geometry.js';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray.js';
import vtkPolyData from '@kitware/vtk.js/Common/DataModel/PolyData.js';
import vtkActor from '@kitware/vtk.js/Rendering/Core/Actor.js';
import vtkLight from '@kitware/vtk.js/Rendering/Core/Light.js';
import vtkMapper from '@kitware/vtk.js/Rendering/Core/Mapper.js';
import type vtkProp3D from '@kitware/vtk.js/Rendering/Core/Prop3D.js';
import vtkRenderer from '@kitware/vtk.js/Rendering/Core/Renderer.js';
import vtkRenderWindow from '@kitware/vtk.js/Rendering/Core/RenderWindow.js';
import type vtkRenderWindowInteractor from '@kitware/vtk.js/Rendering/Core/RenderWindowInteractor.js';
import vtkOpenGLRenderWindow from '@kitware/vtk.js/Rendering/OpenGL/RenderWindow.js';
import type { Camera } from './camera';
import { rgb } from './colors';
import { beyond } from './geometry';
import type { Streamline } from './streamlines';
import type { Surface } from './surface_worker';

export interface SurfaceLook {
  color: string; // '#rrggbb'
  opacity: number; // [1]
}

const coarse = ' coarse'; // end of the key of a coarse surface
const slow_share = 0.7; // of the pixels along an edge, where a program draws; a change of it would wait for all that is being drawn
const still_after_ms = 250; // from the last motion to the fine picture

export class View {
  private readonly window = vtkRenderWindow.newInstance();
  private readonly renderer = vtkRenderer.newInstance();
  private readonly gl = vtkOpenGLRenderWindow.newInstance();
  private readonly props = new Map<string, vtkProp3D>();
  private is_due = false;
  private is_rough = false;
  private shows_surfaces = true;
  private rest_timer = 0;
  readonly can_draw: boolean;
  /** A program draws, no graphics card. */
  private readonly is_slow: boolean;

  constructor(
    private readonly box: HTMLElement,
    private readonly camera: Camera,
  ) {
    this.window.addRenderer(this.renderer);
    this.window.addView(this.gl);
    this.gl.setContainer(box);
    this.renderer.setAutomaticLightCreation(false);
    this.add_light([0.1, 0.2, 1.0], 0.75);
    this.add_light([-0.8, 0.9, 0.5], 0.45);
    this.renderer.getActiveCamera().setParallelProjection(true);
    const context = context_of(this.gl);
    this.can_draw = context !== null;
    this.is_slow = context !== null && /swiftshader|llvmpipe|softpipe|software/i.test(name_of_renderer(context));
  }

  set_ground(color: string): void {
    const [red, green, blue] = rgb(color);
    this.renderer.setBackground(red, green, blue, 1);
    this.draw();
  }

  resize(): void {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.is_slow ? slow_share : 1);
    this.gl.setSize(Math.max(1, Math.round(this.camera.width_px * ratio)), Math.max(1, Math.round(this.camera.height_px * ratio)));
    this.draw();
  }

  /** A coarse surface takes the place of an earlier fine one, and stands in for the fine one while a slow view moves. */
  set_surface(key: string, surface: Surface, map: number[], look: SurfaceLook, is_coarse: boolean): void {
    if (is_coarse) this.remove(key);
    const data = vtkPolyData.newInstance();
    data.getPoints().setData(surface.points, 3);
    data.getPolys().setData(surface.triangles);
    data.getPointData().setNormals(
      vtkDataArray.newInstance({ numberOfComponents: 3, values: surface.normals, name: 'Normals' }),
    );
    const mapper = vtkMapper.newInstance({ scalarVisibility: false });
    mapper.setInputData(data);
    const actor = vtkActor.newInstance();
    actor.setMapper(mapper);
    actor.setUserMatrix(by_column(map) as never);
    const property = actor.getProperty();
    property.setColor(...rgb(look.color));
    property.setOpacity(look.opacity);
    property.setAmbient(0.12);
    property.setDiffuse(0.85);
    property.setSpecular(0.18);
    property.setSpecularPower(24);
    this.show(is_coarse ? key + coarse : key, actor);
    this.move(); // several surfaces come one after the other
  }

  /** Lines in the hand frame, coloured at each point. */
  set_lines(key: string, lines: Streamline[]): void {
    const points: number[] = [], cells: number[] = [], colors: number[] = [];
    for (const line of lines) {
      cells.push(line.points_m.length);
      line.points_m.forEach((at_m, n) => {
        cells.push(points.length / 3);
        points.push(...at_m);
        colors.push(...line.colors[n]);
      });
    }
    const data = vtkPolyData.newInstance();
    data.getPoints().setData(Float32Array.from(points), 3);
    data.getLines().setData(Uint32Array.from(cells));
    data.getPointData().setScalars(
      vtkDataArray.newInstance({ numberOfComponents: 3, values: Uint8Array.from(colors), name: 'colors' }),
    );
    const mapper = vtkMapper.newInstance();
    mapper.setInputData(data);
    const actor = vtkActor.newInstance();
    actor.setMapper(mapper);
    actor.getProperty().setLineWidth(2);
    actor.getProperty().setLighting(false);
    this.show(key, actor);
  }

  show(key: string, prop: vtkProp3D): void {
    this.remove(key);
    this.props.set(key, prop);
    this.renderer.addViewProp(prop);
    this.draw();
  }

  /** Takes a thing out, of a surface also the coarse one. */
  hide(key: string): void {
    this.remove(key);
    this.remove(key + coarse);
    this.draw();
  }

  /** vtk.js' volume mapper asks it whether the view moves. */
  set_interactor(interactor: vtkRenderWindowInteractor): void {
    interactor.setView(this.gl);
    this.window.setInteractor(interactor);
  }

  /** Hides or shows all surfaces. */
  show_surfaces(shows: boolean): void {
    this.shows_surfaces = shows;
    this.draw();
  }

  keys(): string[] {
    return [...this.props.keys()];
  }

  /** The view has moved: a slow one is rough until it rests. */
  move(): void {
    if (this.is_slow) {
      clearTimeout(this.rest_timer);
      this.rest_timer = window.setTimeout(() => this.set_rough(false), still_after_ms);
      this.set_rough(true);
    }
    this.draw();
  }

  private remove(key: string): void {
    const prop = this.props.get(key);
    if (!prop) return;
    this.renderer.removeViewProp(prop);
    prop.delete();
    this.props.delete(key);
  }

  private set_rough(is_rough: boolean): void {
    if (is_rough === this.is_rough) return;
    this.is_rough = is_rough;
    this.draw();
  }

  /** Draws with the browser's next picture. */
  draw(): void {
    if (this.is_due) return;
    this.is_due = true;
    requestAnimationFrame(() => {
      this.is_due = false;
      if (this.box.clientWidth > 0) this.render();
    });
  }

  private choose_surfaces(): void {
    for (const [key, prop] of this.props) {
      if (!key.startsWith('surface')) continue;
      const is_coarse = key.endsWith(coarse);
      const has_other = this.props.has(is_coarse ? key.slice(0, -coarse.length) : key + coarse);
      prop.setVisibility(this.shows_surfaces && (!has_other || is_coarse === this.is_rough));
    }
  }

  private render(): void {
    const { camera } = this;
    this.choose_surfaces();
    const seen = this.renderer.getActiveCamera();
    const away_m = Math.max(1, 4 * camera.half_height_m);
    seen.setFocalPoint(...camera.centre_m);
    seen.setPosition(...beyond(camera.centre_m, away_m, camera.towards));
    seen.setViewUp(...camera.up);
    seen.setParallelScale(camera.half_height_m);
    seen.setClippingRange(0.01 * away_m, 2 * away_m);
    this.window.render();
  }

  private add_light(from: [number, number, number], intensity: number): void {
    const light = vtkLight.newInstance();
    light.setLightTypeToCameraLight();
    light.setPosition(...from);
    light.setFocalPoint(0, 0, 0);
    light.setIntensity(intensity);
    this.renderer.addLight(light);
  }
}

/** WebGL 2, or null without it. */
function context_of(gl: vtkOpenGLRenderWindow): WebGL2RenderingContext | null {
  if (typeof WebGL2RenderingContext !== 'function') return null;
  try {
    gl.initialize();
    return gl.get3DContext({}) as WebGL2RenderingContext | null;
  } catch {
    return null;
  }
}

function name_of_renderer(context: WebGL2RenderingContext): string {
  const names = context.getExtension('WEBGL_debug_renderer_info');
  return String(context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER));
}

/** As WebGL has matrices. */
export function by_column(map: number[]): number[] {
  return [0, 1, 2, 3].flatMap((c) => [map[c], map[4 + c], map[8 + c], map[12 + c]]);
}
