// The three-dimensional scene of the report. viewer/detail/report_scene.cpp writes what `start` reads.
import "@kitware/vtk.js/Rendering/OpenGL/Profiles/Geometry";
import "@kitware/vtk.js/Rendering/OpenGL/ImageMapper";
import "@kitware/vtk.js/Rendering/OpenGL/ImageSlice";
import vtkActor from "@kitware/vtk.js/Rendering/Core/Actor";
import vtkColorTransferFunction from "@kitware/vtk.js/Rendering/Core/ColorTransferFunction";
import vtkDataArray from "@kitware/vtk.js/Common/Core/DataArray";
import vtkImageData from "@kitware/vtk.js/Common/DataModel/ImageData";
import vtkImageMapper from "@kitware/vtk.js/Rendering/Core/ImageMapper";
import vtkImageSlice from "@kitware/vtk.js/Rendering/Core/ImageSlice";
import vtkInteractorStyle from "@kitware/vtk.js/Interaction/Style/InteractorStyleTrackballCamera";
import vtkMapper from "@kitware/vtk.js/Rendering/Core/Mapper";
import vtkOpenGLRenderWindow from "@kitware/vtk.js/Rendering/OpenGL/RenderWindow";
import vtkPlane from "@kitware/vtk.js/Common/DataModel/Plane";
import vtkPolyData from "@kitware/vtk.js/Common/DataModel/PolyData";
import vtkRenderer from "@kitware/vtk.js/Rendering/Core/Renderer";
import vtkRenderWindow from "@kitware/vtk.js/Rendering/Core/RenderWindow";
import vtkRenderWindowInteractor from "@kitware/vtk.js/Rendering/Core/RenderWindowInteractor";
import vtkSphereSource from "@kitware/vtk.js/Filters/Sources/SphereSource";
import vtkTubeFilter from "@kitware/vtk.js/Filters/General/TubeFilter";

const COLORS = {
  tree: [0.8, 0.45, 0.42],
  wall: [0.86, 0.62, 0.58],
  balloon: [0.36, 0.6, 0.86],
  wire: [0.3, 0.32, 0.36],
  lines: [0.13, 0.42, 0.3],
  cursor: [0.95, 0.72, 0.1],
};
// Of contact pressure, as make_pressure_colors() has it for stills, window and film; of how far the wall moved,
// as make_thickness_colors() has it for thicknesses. Both go one way in brightness: readable without colour, too.
const PRESSURE_SCALE = [
  [0, 0.88, 0.88, 0.88], [0.25, 0.99, 0.83, 0.45], [0.5, 0.99, 0.55, 0.24], [0.75, 0.84, 0.18, 0.12], [1, 0.42, 0, 0.05],
];
const LENGTH_SCALE = [
  [0, 0.27, 0, 0.33], [0.25, 0.23, 0.32, 0.55], [0.5, 0.13, 0.57, 0.55], [0.75, 0.37, 0.79, 0.38], [1, 0.99, 0.91, 0.14],
];

// ---- What the page holds: a length, a header in JSON, integers in planes of bytes ----

class Payload {
  constructor(bytes) {
    const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    this.header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    this.bytes = bytes.subarray(4 + length);
  }
  // Differences to the value `stride` places before, their sign in the lowest bit.
  integers({ offset, count, stride }) {
    const out = new Int32Array(count);
    for (let i = 0; i < count; ++i) {
      let word = 0;
      for (let plane = 3; plane >= 0; --plane)
        word = (word << 8) | this.bytes[offset + plane * count + i];
      out[i] = (word >>> 1) ^ -(word & 1);
      if (i >= stride) out[i] += out[i - stride];
    }
    return out;
  }
  // [mm], all frames one after the other
  points({ at, quantum, array }) {
    const whole = this.integers(array);
    return Float32Array.from(whole, (value, i) => at[i % 3] + quantum * value);
  }
}

// ---- Shapes ----

function withTriangles(triangles) {
  const cells = new Uint32Array((triangles.length / 3) * 4);
  for (let t = 0; t < triangles.length / 3; ++t) {
    cells[4 * t] = 3;
    cells.set(triangles.subarray(3 * t, 3 * t + 3), 4 * t + 1);
  }
  const data = vtkPolyData.newInstance();
  data.getPolys().setData(cells);
  return data;
}

// Towards which side a vertex looks: the mean of its triangles, by their area.
function normalsOf(points, triangles) {
  const out = new Float32Array(points.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((k) => points[b + k] - points[a + k]);
    const v = [0, 1, 2].map((k) => points[c + k] - points[a + k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c]) for (let k = 0; k < 3; ++k) out[corner + k] += n[k];
  }
  for (let i = 0; i < out.length; i += 3) {
    const length = Math.hypot(out[i], out[i + 1], out[i + 2]) || 1;
    for (let k = 0; k < 3; ++k) out[i + k] /= length;
  }
  return out;
}

function makeActor(data, color, opacity = 1) {
  const mapper = vtkMapper.newInstance({ scalarVisibility: false });
  mapper.setInputData(data);
  const actor = vtkActor.newInstance();
  actor.setMapper(mapper);
  actor.getProperty().setColor(...color);
  actor.getProperty().setOpacity(opacity);
  return actor;
}

// A surface whose vertices move from frame to frame.
class MovingSurface {
  constructor(payload, description, color, opacity) {
    this.triangles = payload.integers(description.triangles);
    this.course = payload.points(description.points);
    this.vertexCount = description.vertex_count;
    this.data = withTriangles(this.triangles);
    this.actor = makeActor(this.data, color, opacity);
  }
  at(frame) {
    return this.course.subarray(3 * this.vertexCount * frame, 3 * this.vertexCount * (frame + 1));
  }
  show(frame) {
    const points = this.at(frame);
    this.data.getPoints().setData(points, 3);
    this.data.getPointData().setNormals(
      vtkDataArray.newInstance({ name: "Normals", numberOfComponents: 3, values: normalsOf(points, this.triangles) }),
    );
    this.data.modified();
  }
}

class MovingLine {
  constructor(course, vertexCount, color, radius) {
    Object.assign(this, { course, vertexCount });
    this.data = vtkPolyData.newInstance();
    const line = Uint32Array.from({ length: vertexCount + 1 }, (_, i) => (i === 0 ? vertexCount : i - 1));
    this.data.getLines().setData(line);
    const tube = vtkTubeFilter.newInstance({ radius, numberOfSides: 8, capping: true });
    tube.setInputData(this.data);
    this.actor = makeActor(vtkPolyData.newInstance(), color);
    this.actor.getMapper().setInputConnection(tube.getOutputPort());
  }
  show(frame) {
    this.data.getPoints().setData(this.course.slice(3 * this.vertexCount * frame, 3 * this.vertexCount * (frame + 1)), 3);
    this.data.modified();
  }
}

// ---- The fields by which the wall is coloured ----

function fieldsOf(payload, wall) {
  const { pressure } = payload.header.wall;
  const count = wall.vertexCount;
  const values = payload.integers(pressure.array);
  const start = wall.at(0);
  return {
    contact: {
      title: "contact pressure [kPa]",
      scale: PRESSURE_SCALE,
      range: [0, pressure.greatest],
      at: (frame) => Float32Array.from({ length: count }, (_, v) => pressure.quantum * values[count * frame + v]),
    },
    moved: {
      title: "moved since the start [mm]",
      scale: LENGTH_SCALE,
      range: [0, payload.header.wall.greatest_move],
      at: (frame) => {
        const now = wall.at(frame);
        return Float32Array.from({ length: count }, (_, v) =>
          Math.hypot(...[0, 1, 2].map((k) => now[3 * v + k] - start[3 * v + k])),
        );
      },
    },
  };
}

// ---- The scan ----

function makeScan(payload) {
  const { scan } = payload.header;
  if (!scan) return undefined;
  const image = vtkImageData.newInstance({
    origin: scan.origin,
    spacing: scan.spacing,
    direction: scan.direction,
    extent: scan.size.flatMap((n) => [0, n - 1]),
  });
  image.getPointData().setScalars(
    vtkDataArray.newInstance({ name: "scan", values: Uint8Array.from(payload.integers(scan.array)) }),
  );
  const mapper = vtkImageMapper.newInstance();
  mapper.setInputData(image);
  const slice = vtkImageSlice.newInstance();
  slice.setMapper(mapper);
  slice.getProperty().setColorWindow(255);
  slice.getProperty().setColorLevel(127.5);
  slice.setVisibility(false);
  return { slice, mapper, size: scan.size };
}

// ---- The window ----

export class Scene {
  constructor(element, bytes) {
    const payload = new Payload(bytes);
    const { header } = payload;
    this.header = header;
    this.frame = 0;
    this.renderer = vtkRenderer.newInstance({ background: [0.93, 0.94, 0.96] });
    this.window = vtkRenderWindow.newInstance();
    this.window.addRenderer(this.renderer);
    this.view = vtkOpenGLRenderWindow.newInstance();
    this.view.setContainer(element);
    this.window.addView(this.view);
    this.interactor = vtkRenderWindowInteractor.newInstance();
    this.interactor.setView(this.view);
    this.interactor.initialize();
    this.interactor.bindEvents(element);
    this.interactor.setInteractorStyle(vtkInteractorStyle.newInstance());

    this.plane = vtkPlane.newInstance();
    this.layers = {};
    this.movers = [];
    this.addTree(payload);
    this.addTreatment(payload);
    this.scan = makeScan(payload);
    if (this.scan) this.renderer.addActor(this.scan.slice);
    this.addCursor();
    this.resize(element);
    new ResizeObserver(() => this.resize(element)).observe(element);
    this.showFrame(0);
    this.lookAt("lesion");
  }

  add(layer, actor) {
    (this.layers[layer] ??= []).push(actor);
    this.renderer.addActor(actor);
  }

  addTree(payload) {
    const { tree, lines } = this.header;
    if (tree) {
      const triangles = payload.integers(tree.triangles);
      const points = payload.points(tree.points);
      const data = withTriangles(triangles);
      data.getPoints().setData(points, 3);
      data.getPointData().setNormals(
        vtkDataArray.newInstance({ name: "Normals", numberOfComponents: 3, values: normalsOf(points, triangles) }),
      );
      this.add("tree", makeActor(data, COLORS.tree, 0.35));
    }
    for (const line of lines) {
      const mover = new MovingLine(payload.points(line.points), line.vertex_count, COLORS.lines, this.header.line_radius);
      mover.show(0);
      this.add("lines", mover.actor);
    }
  }

  addTreatment(payload) {
    const { wall, balloon, wire } = this.header;
    if (!wall) return;
    this.wall = new MovingSurface(payload, wall, COLORS.wall, 0.55);
    this.fields = fieldsOf(payload, this.wall);
    this.add("wall", this.wall.actor);
    const inner = new MovingSurface(payload, balloon, COLORS.balloon, 1);
    this.add("balloon", inner.actor);
    this.movers.push(this.wall, inner);
    if (wire) {
      const mover = new MovingLine(payload.points(wire.points), wire.vertex_count, COLORS.wire, wire.radius);
      this.add("wire", mover.actor);
      this.movers.push(mover);
    }
  }

  addCursor() {
    const { diameters } = this.header;
    if (!diameters) return;
    this.sphere = vtkSphereSource.newInstance({ radius: this.header.cursor_radius, thetaResolution: 20, phiResolution: 14 });
    const actor = makeActor(vtkPolyData.newInstance(), COLORS.cursor);
    actor.getMapper().setInputConnection(this.sphere.getOutputPort());
    this.add("cursor", actor);
    this.placeCursor(diameters.narrowest);
  }

  resize(element) {
    const { width, height } = element.getBoundingClientRect();
    const scale = window.devicePixelRatio || 1;
    this.view.setSize(Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale)));
    this.render();
  }

  render() {
    this.renderer.resetCameraClippingRange();
    this.window.render();
  }

  showFrame(frame) {
    this.frame = frame;
    for (const mover of this.movers) mover.show(frame);
    this.color(this.field);
  }

  // @param field  of `fields`; undefined: one colour
  color(field) {
    this.field = field;
    if (!this.wall) return this.render();
    const mapper = this.wall.actor.getMapper();
    const chosen = field && this.fields[field];
    mapper.setScalarVisibility(Boolean(chosen));
    this.wall.actor.getProperty().setOpacity(chosen ? 1 : 0.55);
    if (chosen) {
      this.wall.data.getPointData().setScalars(vtkDataArray.newInstance({ name: field, values: chosen.at(this.frame) }));
      const scale = vtkColorTransferFunction.newInstance();
      const top = chosen.range[1] || 1;
      for (const [share, ...rgb] of chosen.scale) scale.addRGBPoint(share * top, ...rgb);
      mapper.setLookupTable(scale);
      mapper.setUseLookupTableScalarRange(true);
      mapper.setInterpolateScalarsBeforeMapping(false);
    }
    this.render();
  }

  setVisible(layer, visible) {
    for (const actor of this.layers[layer] ?? []) actor.setVisibility(visible);
    this.render();
  }

  // Cuts away what lies before a plane through the lesion that faces the viewer; undefined: nothing.
  cut(depth) {
    for (const layer of ["tree", "wall", "balloon"])
      for (const actor of this.layers[layer] ?? []) {
        const mapper = actor.getMapper();
        mapper.removeAllClippingPlanes();
        if (depth !== undefined) mapper.addClippingPlane(this.plane);
      }
    if (depth !== undefined) {
      const normal = this.renderer.getActiveCamera().getDirectionOfProjection();
      const { center, reach } = this.header.lesion;
      this.plane.setNormal(...normal);
      this.plane.setOrigin(...center.map((c, k) => c + depth * reach * normal[k]));
    }
    this.render();
  }

  // @param axis  0, 1, 2 of the scan's grid; undefined: none  @param share  along it, 0 to 1
  slice(axis, share) {
    if (!this.scan) return;
    this.scan.slice.setVisibility(axis !== undefined);
    if (axis !== undefined) {
      this.scan.mapper.setSlicingMode(axis);
      this.scan.mapper.setSlice(Math.round(share * (this.scan.size[axis] - 1)));
    }
    this.render();
  }

  placeCursor(index) {
    this.sphere.setCenter(...this.header.diameters.points[index]);
    this.render();
  }

  lookAt(what) {
    const camera = this.renderer.getActiveCamera();
    const { center, reach, from, up } = this.header.lesion;
    camera.setFocalPoint(...center);
    camera.setPosition(...center.map((c, k) => c + from[k]));
    camera.setViewUp(...up);
    if (what === "tree") this.renderer.resetCamera();
    else this.renderer.resetCamera(center.flatMap((c) => [c - reach, c + reach]));
    this.render();
  }
}
