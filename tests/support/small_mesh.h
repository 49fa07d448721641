// SPDX-License-Identifier: Apache-2.0
//
// Ghost meshes made by hand, small enough to damage their files byte by byte.
#pragma once

#include "core/mesh/ghost_mesh.h"

namespace flare::test {

// Vertices nu x nv, all alive; every float is different, and grows with `start`.
inline MeshGrid SmallGrid(const GhostMesh& mesh, int nu, int nv, float start) {
    MeshGrid grid;
    grid.u0 = -1.5;
    grid.v0 = 0.25;
    grid.du = 0.125;
    grid.dv = 1e-3;
    grid.nu = nu;
    grid.nv = nv;
    const auto vertices = static_cast<std::size_t>(nu) * static_cast<std::size_t>(nv);
    grid.alive.assign(vertices, 1);
    grid.cells.assign(static_cast<std::size_t>(nu - 1) * static_cast<std::size_t>(nv - 1),
                      CellUse::kUsed);
    for (const double wavelength_nm : {450.5, 587.5618}) {
        MeshNode node;
        node.wavelength_nm = wavelength_nm;
        node.fields.resize(vertices * static_cast<std::size_t>(mesh.stored_count()));
        node.passage.resize(vertices * static_cast<std::size_t>(mesh.passage_count()));
        for (float& value : node.fields) value = start += 0.37F;
        for (float& value : node.passage) value = -(start += 0.11F);
        grid.nodes.push_back(std::move(node));
    }
    return grid;
}

// A mesh with one patch that has a dead corner.
inline GhostMesh SmallMesh(float start = 1.0F) {
    GhostMesh mesh;
    mesh.sequence = {5, 2};
    mesh.field_rad = 0.1;
    mesh.azimuth_rad = 0.2;
    mesh.inverse_distance = 0.3;
    mesh.stop_crossings = 1;
    mesh.interactions = 2;
    mesh.rims = {1};
    mesh.absorbing = {0};
    mesh.rays_traced = 1234;
    mesh.ray_surfaces = (std::uint64_t{1} << 40) + 5;
    mesh.grids.push_back(SmallGrid(mesh, 3, 2, start));
    mesh.grids.back().cells[1] = CellUse::kPatched;
    mesh.grids.push_back(SmallGrid(mesh, 2, 2, start + 100.0F));
    MeshGrid& patch = mesh.grids.back();
    patch.smooth = false;
    patch.alive[2] = 0;
    patch.cells[0] = CellUse::kTriangle;
    return mesh;
}

inline bool SameNode(const MeshNode& a, const MeshNode& b) {
    return a.wavelength_nm == b.wavelength_nm && a.fields == b.fields && a.passage == b.passage;
}

inline bool SameGrid(const MeshGrid& a, const MeshGrid& b) {
    if (a.nodes.size() != b.nodes.size()) return false;
    for (std::size_t k = 0; k < a.nodes.size(); ++k) {
        if (!SameNode(a.nodes[k], b.nodes[k])) return false;
    }
    return a.u0 == b.u0 && a.v0 == b.v0 && a.du == b.du && a.dv == b.dv && a.nu == b.nu &&
           a.nv == b.nv && a.smooth == b.smooth && a.alive == b.alive && a.cells == b.cells;
}

inline bool SameMesh(const GhostMesh& a, const GhostMesh& b) {
    if (a.grids.size() != b.grids.size()) return false;
    for (std::size_t g = 0; g < a.grids.size(); ++g) {
        if (!SameGrid(a.grids[g], b.grids[g])) return false;
    }
    return a.sequence == b.sequence && a.field_rad == b.field_rad &&
           a.azimuth_rad == b.azimuth_rad && a.inverse_distance == b.inverse_distance &&
           a.stop_crossings == b.stop_crossings && a.interactions == b.interactions &&
           a.rims == b.rims && a.absorbing == b.absorbing && a.rays_traced == b.rays_traced &&
           a.ray_surfaces == b.ray_surfaces;
}

}  // namespace flare::test
