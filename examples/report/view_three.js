// SPDX-License-Identifier: MIT
// The view by three.js (WebGL). A view takes swimmers, a list of {name, segments, colour, width}, and draws them when
// told; turning it with the mouse calls `changed`.

function createThreeView(host, swimmers, lines, box, changed) {
  const canvas = element("canvas", {tabindex: "0", "aria-label": "Swimmers; drag to turn, scroll to zoom"});
  const renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
  host.append(canvas);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color();
  const camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableKeys = false; // the arrow keys step through time
  controls.addEventListener("change", changed);
  scene.add(new THREE.HemisphereLight(0xffffff, 0xe2eaee, 0.62));
  const sun = new THREE.DirectionalLight(0xffffff, 0.48);
  sun.position.set(-0.25, -0.45, 0.857);
  scene.add(sun);

  const bodies = swimmers.map((s) => {
    const geometry = new THREE.BufferGeometry(), shadow = new THREE.BufferGeometry();
    const attribute = (array) => new THREE.BufferAttribute(array, 3).setUsage(THREE.DynamicDrawUsage);
    geometry.setIndex(new THREE.BufferAttribute(s.index, 1));
    geometry.setAttribute("position", attribute(s.positions));
    geometry.setAttribute("normal", attribute(s.normals));
    geometry.setAttribute("color", attribute(s.colours));
    const flat = new Float32Array(s.positions.length);
    shadow.setIndex(new THREE.BufferAttribute(s.index, 1));
    shadow.setAttribute("position", attribute(flat));
    const body = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({vertexColors: THREE.VertexColors, roughness: 0.55, metalness: 0}));
    const dark = new THREE.Mesh(shadow, new THREE.MeshBasicMaterial({side: THREE.DoubleSide}));
    body.frustumCulled = dark.frustumCulled = false;
    scene.add(dark, body);
    return {s, geometry, shadow, flat, dark, body};
  });
  const wires = lines.map((line) => {
    const geometry = new THREE.BufferGeometry(), wide = line.width > 2;
    const array = wide ? new Float32Array(3 * line.segments.length) : line.segments;
    geometry.setAttribute("position", new THREE.BufferAttribute(array, 3).setUsage(THREE.DynamicDrawUsage));
    const wire = wide ? new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({side: THREE.DoubleSide}))
                      : new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
    wire.frustumCulled = false;
    scene.add(wire);
    return {line, geometry, wire, wide, array};
  });

  return {
    kind: "three",
    canvas,
    resize(width, height) {
      renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 3));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
    },
    look(direction) {
      const from = lookAt(shownBox(swimmers, box), direction, camera.aspect);
      camera.position.set(...from.eye);
      controls.target.set(...from.target);
      controls.update();
    },
    draw() {
      scene.background.set(theme("--water"));
      for (const {s, geometry, shadow, flat, dark, body} of bodies) {
        dark.visible = body.visible = !s.hidden;
        for (let i = 0; i < flat.length; i += 3) flat[i] = s.positions[i], flat[i + 1] = s.positions[i + 1], flat[i + 2] = box.floor - 0.002;
        dark.material.color.set(theme("--shadow"));
        shadow.attributes.position.needsUpdate = true;
        for (const name of ["position", "normal", "color"]) geometry.attributes[name].needsUpdate = true;
      }
      for (const {line, geometry, wire, wide, array} of wires) {
        if (wide) ribbons(line.segments, 0.003 * line.width * box.length, array);
        wire.material.color.set(theme(line.colour));
        geometry.attributes.position.needsUpdate = true;
      }
      renderer.render(scene, camera);
    },
    // Pixels of a point in the view.
    project(point) {
      const p = new THREE.Vector3(...point).project(camera);
      return [(p.x + 1) / 2 * host.clientWidth, (1 - p.y) / 2 * host.clientHeight];
    },
  };
}
