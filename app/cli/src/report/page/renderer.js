// A renderer of solids with light and shadow, a floor, see-through ghosts, and lines.

const SHADOW_SIZE = 2048;
const LIGHT = unit([0.42, -0.38, 0.82]);

class Renderer {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
    if (!gl) throw new Error("this browser has no WebGL 2, so the robot cannot be shown");
    this.canvas = canvas;
    this.gl = gl;
    this.solidProgram = this.program(SOLID_VERTEX, SOLID_FRAGMENT);
    this.depthProgram = this.program(SOLID_VERTEX, DEPTH_FRAGMENT);
    this.groundProgram = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.lineProgram = this.program(LINE_VERTEX, LINE_FRAGMENT);
    this.solids = {
      ball: this.upload(ballSolid()),
      dome: this.upload(domeSolid()),
      tube: this.upload(tubeSolid()),
      cylinder: this.upload(cylinderSolid()),
      box: this.upload(boxSolid()),
    };
    this.quad = this.upload({ positions: [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], normals: new Array(12).fill(0), triangles: [0, 1, 2, 0, 2, 3] });
    this.makeShadowMap();
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const at = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i += 1) {
      const { name } = gl.getActiveUniform(program, i);
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  upload({ positions, normals, triangles }) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    [positions, normals].forEach((numbers, location) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(triangles), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, count: triangles.length };
  }

  // A path through points, three numbers each.
  uploadPath(points) {
    const { gl } = this;
    const array = gl.createVertexArray();
    const buffer = gl.createBuffer();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.DYNAMIC_DRAW);
    for (const location of [0, 1]) {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 12, 12 * location);
      gl.vertexAttribDivisor(location, 1);
    }
    gl.bindVertexArray(null);
    return { array, buffer, parts: points.length / 3 - 1 };
  }

  updatePath(path, points) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, path.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, new Float32Array(points));
  }

  makeShadowMap() {
    const { gl } = this;
    this.shadowTexture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowTexture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    this.shadowBuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadowTexture, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  // Draws solids of a list: { solid, model, scale, color }.
  drawSolids(list, at) {
    const { gl } = this;
    for (const item of list) {
      gl.uniformMatrix4fv(at.model, false, item.model);
      gl.uniform3fv(at.scale, item.scale);
      if (at.color) {
        gl.uniform4fv(at.color, item.color);
        gl.uniform1f(at.edged, item.solid === this.solids.box && item.color[3] < 1 ? 1 : 0);
      }
      gl.bindVertexArray(item.solid.array);
      gl.drawElements(gl.TRIANGLES, item.solid.count, gl.UNSIGNED_INT, 0);
    }
  }

  useDepth(viewProjection) {
    const { gl } = this;
    gl.useProgram(this.depthProgram.program);
    gl.uniformMatrix4fv(this.depthProgram.at.viewProjection, false, viewProjection);
    return this.depthProgram.at;
  }

  // The scene: opaque, seeThrough and lists of ghosts; lines; ground; bounds { centre, radius };
  // camera { eye, matrix }; colours.
  draw(scene) {
    const { gl, canvas } = this;
    const { centre, radius } = scene.bounds;
    const from = add(centre, scaled(LIGHT, 3 * radius));
    const lightMatrix = times(orthographic(1.25 * radius, radius, 5 * radius), lookAt(from, centre, [0, 0, 1]));
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
    gl.depthFunc(gl.LEQUAL);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowBuffer);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    const depth = this.useDepth(lightMatrix);
    this.drawSolids(scene.opaque, depth);
    this.drawSolids(scene.seeThrough, depth);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const lighting = ({ program, at }) => {
      gl.useProgram(program);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.shadowTexture);
      gl.uniform1i(at.shadows, 0);
      gl.uniform1f(at.texel, 1 / SHADOW_SIZE);
      gl.uniformMatrix4fv(at.lightMatrix, false, lightMatrix);
      gl.uniformMatrix4fv(at.viewProjection, false, scene.camera.matrix);
      return at;
    };
    const solids = () => {
      const at = lighting(this.solidProgram);
      gl.uniform3fv(at.light, LIGHT);
      gl.uniform3fv(at.eye, scene.camera.eye);
      gl.uniform1f(at.bias, 0.006 * radius);
      gl.uniform1f(at.shine, 1);
      return at;
    };
    this.drawSolids(scene.opaque, solids());
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    if (scene.ground) {
      const at = lighting(this.groundProgram);
      gl.uniform3fv(at.centre, [centre[0], centre[1], scene.ground.z]);
      gl.uniform1f(at.radius, 4.5 * radius);
      gl.uniform1f(at.spacing, scene.ground.spacing);
      gl.uniform3fv(at.floorColor, scene.ground.floor);
      gl.uniform3fv(at.lineColor, scene.ground.line);
      gl.uniform1f(at.shade, scene.ground.shade);
      gl.bindVertexArray(this.quad.array);
      gl.drawElements(gl.TRIANGLES, this.quad.count, gl.UNSIGNED_INT, 0);
    }
    // Convex solids have one visible layer each; the distant ones are drawn first.
    const away = (item) => norm(subtract([item.model[12], item.model[13], item.model[14]], scene.camera.eye));
    gl.enable(gl.CULL_FACE);
    this.drawSolids([...scene.seeThrough].sort((a, b) => away(b) - away(a)), solids());
    gl.disable(gl.CULL_FACE);
    // Only the nearest layer of a ghost is drawn.
    for (const ghost of scene.ghosts) {
      gl.depthMask(true);
      gl.colorMask(false, false, false, false);
      this.drawSolids(ghost, this.useDepth(scene.camera.matrix));
      gl.colorMask(true, true, true, true);
      gl.depthMask(false);
      this.drawSolids(ghost, solids());
    }
    this.drawLines(scene);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  drawLines(scene) {
    const { gl, canvas } = this;
    const { program, at } = this.lineProgram;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.viewProjection, false, scene.camera.matrix);
    gl.uniform2f(at.size, canvas.width, canvas.height);
    const faint = (color, by) => [color[0], color[1], color[2], color[3] * by];
    for (const line of scene.lines) {
      gl.uniform1f(at.width, line.width * scene.pixels);
      gl.uniform1f(at.split, line.split ?? Infinity);
      gl.bindVertexArray(line.path.array);
      // Hidden parts are drawn faintly.
      for (const [hidden, by] of [[true, line.hidden ?? 0.28], [false, 1]]) {
        gl.depthFunc(hidden ? gl.GREATER : gl.LEQUAL);
        gl.uniform4fv(at.before, faint(line.color, by));
        gl.uniform4fv(at.after, faint(line.after ?? line.color, by));
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, line.path.parts);
      }
    }
    gl.depthFunc(gl.LEQUAL);
  }
}
