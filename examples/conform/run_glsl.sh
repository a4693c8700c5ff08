#!/bin/sh
# SPDX-License-Identifier: MIT
# Evaluate a GLSL shader at the sets and directions of a kit, in a headless Chromium (WebGL 2), and write the values as an array of NumPy.
# usage: run_glsl.sh KIT.glsl SHADER.glsl VALUES.npy
set -eu
[ $# = 3 ] || { echo "usage: run_glsl.sh KIT.glsl SHADER.glsl VALUES.npy" >&2; exit 2; }
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || { echo "run_glsl.sh: there is no Chromium" >&2; exit 3; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
n_sets=$(sed -n 's/^const int nqm_n_sets = \([0-9]*\), nqm_n_directions = [0-9]*;/\1/p' "$1")
n_directions=$(sed -n 's/^const int nqm_n_sets = [0-9]*, nqm_n_directions = \([0-9]*\);/\1/p' "$1")
{
    echo '<script id="shader" type="text/plain">#version 300 es'
    echo 'precision highp float; precision highp int;'
    cat "$1" "$2"
    echo "</script><pre id='values'></pre><script>const width = $n_directions, height = $n_sets;"
    cat <<'SCRIPT'
function run() {
    const gl = document.createElement("canvas").getContext("webgl2");
    if (!gl || !gl.getExtension("EXT_color_buffer_float")) return "error: no WebGL 2 with targets of floats";
    const program = gl.createProgram();
    const sources = ["#version 300 es\nvoid main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0, 1); }",
                     document.getElementById("shader").textContent];
    for (const [i, kind] of [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].entries()) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, sources[i]);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) return "error: " + gl.getShaderInfoLog(shader);
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return "error: " + gl.getProgramInfoLog(program);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
    const texture = gl.getParameter(gl.TEXTURE_BINDING_2D);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.useProgram(program);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const rgba = new Float32Array(4 * width * height), rgb = new Float32Array(3 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, rgba);
    for (let i = 0; i < width * height; ++i) rgb.set(rgba.subarray(4 * i, 4 * i + 3), 3 * i);
    let text = `{'descr': '<f4', 'fortran_order': False, 'shape': (${height}, ${width}, 3), }`;
    text = text.padEnd(117) + "\n";
    let bytes = "\x93NUMPY\x01\x00" + String.fromCharCode(text.length, 0) + text;
    for (const byte of new Uint8Array(rgb.buffer)) bytes += String.fromCharCode(byte);
    return "npy:" + btoa(bytes);
}
document.getElementById("values").textContent = run();
</script>
SCRIPT
} >"$folder/page.html"
timeout 300 "$browser" --headless --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage --proxy-server=127.0.0.1:9 \
    --virtual-time-budget=1000 --user-data-dir="$folder/profile" --dump-dom "file://$folder/page.html" 2>"$folder/err" >"$folder/dom"
sed -n 's/.*npy:\([A-Za-z0-9+\/=]*\).*/\1/p' "$folder/dom" | base64 -d >"$3"
[ -s "$3" ] || { sed -n '/error: /,/<\/pre>/p' "$folder/dom" >&2; rm -f "$3"; exit 1; }
