// Draws a .glb with three.js inside a page that script/peers/three_frames.mjs opens.
import * as THREE from 'three';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';
import {HDRLoader} from 'three/addons/loaders/HDRLoader.js';

const lampSide = 1024, sunSide = 2048; // of shadow maps, as Sideray's are at most
const skyTurn = Math.PI / 2; // the middle of a lat-long picture is -Z
let renderer, scene, camera, bounds;

// The box in which a sun casts shadows: all of the scene.
function coverScene(sun) {
  const reach = bounds.radius + bounds.center.distanceTo(sun.getWorldPosition(new THREE.Vector3()));
  Object.assign(sun.shadow.camera, {left: -reach, right: reach, top: reach, bottom: -reach, near: -reach, far: reach});
}

function castShadows(object) {
  if (object.isLight && object.shadow) {
    const side = object.isDirectionalLight ? sunSide : lampSide;
    object.castShadow = true;
    object.shadow.mapSize.set(side, side);
    object.shadow.normalBias = 0.02;
    if (object.isDirectionalLight) coverScene(object);
    else object.shadow.camera.near = 0.02;
  }
  if (object.isMesh) {
    object.receiveShadow = true;
    object.castShadow = !object.material.transparent && !object.material.transmission;
  }
}

async function surround(url) {
  const sky = await new HDRLoader().loadAsync(url);
  sky.mapping = THREE.EquirectangularReflectionMapping;
  scene.environment = scene.background = sky;
  scene.environmentRotation.y = scene.backgroundRotation.y = skyTurn;
}

// The canvas stays outside the document: the page is never composited while a frame is timed.
window.setUp = async ({width, height, cameraIndex, sky}) => {
  renderer = new THREE.WebGLRenderer({antialias: true});
  renderer.debug.onShaderError = (gl, program, vertex, fragment) => {
    throw new Error(`a shader fails: ${gl.getProgramInfoLog(program)} ${gl.getShaderInfoLog(fragment)}`);
  };
  renderer.setPixelRatio(1);
  renderer.setSize(width, height, false);
  renderer.toneMapping = THREE.NoToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.PCFShadowMap;
  const content = await new GLTFLoader().loadAsync('/scene.glb');
  scene = new THREE.Scene();
  scene.add(content.scene);
  scene.updateMatrixWorld();
  bounds = new THREE.Box3().setFromObject(scene).getBoundingSphere(new THREE.Sphere());
  scene.traverse(castShadows);
  if (sky) await surround('/sky.hdr');
  camera = content.cameras[cameraIndex];
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  const gl = renderer.getContext();
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  return {version: THREE.REVISION, gl: gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER)};
};

// Milliseconds of a frame from a camera moved sideways by a share of the picture, so that no earlier frame can be shown
// again. Reading a pixel back waits for all that was drawn.
window.drawFrame = shift => {
  const gl = renderer.getContext();
  const {width, height} = gl.canvas;
  const start = performance.now();
  camera.setViewOffset(width, height, shift * width, 0, width, height);
  renderer.render(scene, camera);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const error = gl.getError();
  if (error || gl.isContextLost()) throw new Error(`OpenGL error ${error}, context lost: ${gl.isContextLost()}`);
  return performance.now() - start;
};

window.drawPicture = () => {
  window.drawFrame(0);
  return renderer.domElement.toDataURL('image/png');
};
