"""PyMeshLab in a separate environment: measures of a triangle mesh."""

import json
import sys

import numpy as np
import pymeshlab

MEASURES = {
    "free edges": "boundary_edges",
    "edges of more than two triangles": "non_two_manifold_edges",
    "bow-tie vertices": "non_two_manifold_vertices",
    "unreferenced vertices": "unreferenced_vertices",
    "parts": "connected_components_number",
}


def main() -> None:
    surfaces = {path: np.load(path) for path in sys.argv[1:]}
    print("ready", flush=True)
    loaded = {}
    for line in sys.stdin:
        path = line.strip()
        if path not in loaded:
            loaded[path] = pymeshlab.MeshSet()
            mesh = surfaces[path]
            loaded[path].add_mesh(
                pymeshlab.Mesh(mesh["points"], mesh["triangles"].astype(np.int32))
            )
        print(json.dumps(findings(loaded[path])), flush=True)


def findings(meshes: pymeshlab.MeshSet) -> dict[str, int]:
    measures = meshes.get_topological_measures()
    meshes.compute_selection_by_self_intersections_per_face()
    crossing = meshes.current_mesh().selected_face_number()
    return {name: int(measures[key]) for name, key in MEASURES.items()} | {
        "triangles that cross others": crossing
    }


if __name__ == "__main__":
    main()
