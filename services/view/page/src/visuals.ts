/// The visual elements of a URDF, with their meshes: STL (urdf-loader), COLLADA, OBJ and glTF (three's loaders).
import * as THREE from "three";
import { ColladaLoader } from "three/examples/jsm/loaders/ColladaLoader.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { MTLLoader } from "three/examples/jsm/loaders/MTLLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import URDFLoader from "urdf-loader";

type Load = URDFLoader["loadMeshCb"];
type Done = Parameters<Load>[3];

/** Objects by the name of their link, in the frame of the link. Waits until the meshes are there; an object whose mesh cannot be loaded is empty. */
export async function loadVisuals(url: string): Promise<Map<string, THREE.Object3D[]>> {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
  const manager = new THREE.LoadingManager();
  const loader = new URDFLoader(manager);
  loader.parseVisual = true;
  loader.parseCollision = false;
  const failed: string[] = [];
  const standard = loader.loadMeshCb.bind(loader);
  loader.loadMeshCb = (path, meshes, material, done) => {
    // urdf-loader writes each error to the console, but it is a warning: the shapes of the link are drawn.
    const fail = (): void => {
      if (!failed.includes(path)) failed.push(path);
      done(new THREE.Group());
    };
    loadMesh(standard, path, meshes, material, (object, error) => (error || !object ? fail() : done(object)));
  };
  manager.onError = (path) => failed.includes(path) || failed.push(path);
  const loaded = new Promise<void>((resolve) => (manager.onLoad = resolve));
  const key = "text";
  manager.itemStart(key);
  const robot = loader.parse(await answer.text());
  manager.itemEnd(key);
  await loaded;
  if (failed.length) console.warn(`meshes that could not be loaded: ${failed.join(", ")}`);

  const byLink = new Map<string, THREE.Object3D[]>();
  for (const [name, link] of Object.entries(robot.links)) {
    const visuals = link.children.filter((child) => (child as { isURDFVisual?: boolean }).isURDFVisual);
    if (visuals.length) byLink.set(name, visuals);
  }
  return byLink;
}

function loadMesh(standard: Load, path: string, manager: THREE.LoadingManager, material: THREE.Material,
                  done: Done): void {
  const extension = path.slice(path.lastIndexOf(".") + 1).toLowerCase();
  const fail = (error: unknown): void => done(new THREE.Group(), error instanceof Error ? error : new Error(path));
  if (extension === "glb" || extension === "gltf") {
    new GLTFLoader(manager).load(path, (model) => done(model.scene), undefined, fail);
  } else if (extension === "obj" || extension === "dae") {
    manager.itemStart(path);
    (extension === "obj" ? loadObj : loadCollada)(path, manager).then(done, fail).finally(() => manager.itemEnd(path));
  } else {
    standard(path, manager, material, done);
  }
}

async function textOf(path: string): Promise<string> {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
  return answer.text();
}

/** three's loader writes what is no XML to the console. */
async function loadCollada(path: string, manager: THREE.LoadingManager): Promise<THREE.Object3D> {
  const text = await textOf(path);
  const broken = new DOMParser().parseFromString(text, "application/xml").querySelector("parsererror");
  if (broken) throw new Error(`${path} is no XML`);
  const model = new ColladaLoader(manager).parse(text, path.slice(0, path.lastIndexOf("/") + 1));
  if (!model) throw new Error(`${path} is no COLLADA file`);
  return model.scene;
}

/** An OBJ may name a file of materials beside it. */
async function loadObj(path: string, manager: THREE.LoadingManager): Promise<THREE.Object3D> {
  const loader = new OBJLoader(manager);
  const text = await textOf(path);
  const library = /^mtllib\s+(.+?)\s*$/m.exec(text)?.[1];
  if (library) {
    const folder = path.slice(0, path.lastIndexOf("/") + 1);
    const answer = await fetch(folder + library);
    if (answer.ok) {
      const materials = new MTLLoader(manager).parse(await answer.text(), folder);
      materials.preload();
      loader.setMaterials(materials);
    }
  }
  return loader.parse(text);
}
