// SPDX-License-Identifier: Apache-2.0
//
// Members are taken by structured bindings, so that a member added to a mesh does not compile until
// it stands in the file too.
#include "server/cache/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

namespace flare {
namespace {

constexpr std::string_view kMagic = "FLRMESH\n";
constexpr std::size_t kChecksumAt = 40;

// A vertex list, a patch list or a field list longer than this is no mesh of ours.
constexpr std::uint64_t kMostItems = std::uint64_t{1} << 28;

Fingerprint Checksum(std::string_view head, std::string_view payload) {
    return Fingerprinter().Add(head).Add(payload).value();
}

class Writer {
  public:
    template <std::unsigned_integral T>
    void Put(T value) {
        for (unsigned i = 0; i < sizeof(T); ++i) {
            bytes_.push_back(static_cast<char>(static_cast<unsigned char>(value >> (8U * i))));
        }
    }
    void Put(int value) { Put(static_cast<std::uint32_t>(value)); }
    void Put(double value) { Put(std::bit_cast<std::uint64_t>(value)); }
    void Put(bool value) { Put(static_cast<std::uint8_t>(value ? 1 : 0)); }
    void Put(const Fingerprint& value) {
        Put(value.high);
        Put(value.low);
    }
    void PutCount(std::size_t count) { Put(static_cast<std::uint64_t>(count)); }
    void PutInts(const std::vector<int>& values) {
        PutCount(values.size());
        for (const int value : values) Put(value);
    }
    void PutBytes(std::string_view bytes) { bytes_.append(bytes); }

    // Without their number, which follows from the mesh.
    void PutFloats(const std::vector<float>& values) {
        if constexpr (std::endian::native == std::endian::little) {
            const std::size_t at = bytes_.size();
            bytes_.resize(at + values.size() * sizeof(float));
            if (!values.empty()) {
                std::memcpy(&bytes_[at], values.data(), values.size() * sizeof(float));
            }
        } else {
            for (const float value : values) Put(std::bit_cast<std::uint32_t>(value));
        }
    }

    // `bits` of each value, 8 / bits of them a byte, the first in the lowest bits.
    template <class T>
    void PutPacked(const std::vector<T>& values, unsigned bits) {
        const std::size_t in_byte = 8 / bits;
        for (std::size_t i = 0; i < values.size(); i += in_byte) {
            unsigned byte = 0;
            for (std::size_t k = 0; k < in_byte && i + k < values.size(); ++k) {
                byte |= static_cast<unsigned>(values[i + k]) << (bits * static_cast<unsigned>(k));
            }
            Put(static_cast<std::uint8_t>(byte));
        }
    }

    void Reserve(std::size_t bytes) { bytes_.reserve(bytes); }
    std::string Take() { return std::move(bytes_); }

  private:
    std::string bytes_;
};

// Every Get says whether the bytes were there and made sense; nothing is allocated before.
class Reader {
  public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    bool done() const { return bytes_.empty(); }

    template <std::unsigned_integral T>
    bool Get(T& value) {
        if (bytes_.size() < sizeof(T)) return false;
        value = 0;
        for (unsigned i = 0; i < sizeof(T); ++i) {
            value = static_cast<T>(
                value |
                static_cast<T>(static_cast<T>(static_cast<unsigned char>(bytes_[i])) << (8U * i)));
        }
        bytes_.remove_prefix(sizeof(T));
        return true;
    }
    bool Get(int& value) {
        std::uint32_t bits = 0;
        if (!Get(bits)) return false;
        value = static_cast<int>(bits);
        return true;
    }
    bool Get(double& value) {
        std::uint64_t bits = 0;
        if (!Get(bits)) return false;
        value = std::bit_cast<double>(bits);
        return std::isfinite(value);
    }
    bool Get(bool& value) {
        std::uint8_t byte = 0;
        if (!Get(byte) || byte > 1) return false;
        value = byte == 1;
        return true;
    }
    bool Get(Fingerprint& value) { return Get(value.high) && Get(value.low); }

    // Of items that take at least so many bytes each.
    bool GetCount(std::size_t item_bytes, std::uint64_t& count) {
        return Get(count) && count <= bytes_.size() / item_bytes;
    }
    bool GetInts(std::vector<int>& values) {
        std::uint64_t count = 0;
        if (!GetCount(sizeof(std::uint32_t), count)) return false;
        values.resize(count);
        return std::all_of(values.begin(), values.end(), [this](int& value) { return Get(value); });
    }

    bool GetFloats(std::uint64_t count, std::vector<float>& values) {
        if (count > bytes_.size() / sizeof(float)) return false;
        values.resize(count);
        if constexpr (std::endian::native == std::endian::little) {
            if (count > 0) std::memcpy(values.data(), bytes_.data(), count * sizeof(float));
            bytes_.remove_prefix(count * sizeof(float));
        } else {
            for (float& value : values) {
                std::uint32_t bits = 0;
                if (!Get(bits)) return false;
                value = std::bit_cast<float>(bits);
            }
        }
        return true;
    }

    template <class T>
    bool GetPacked(std::uint64_t count, unsigned bits, std::vector<T>& values) {
        const std::uint64_t in_byte = 8 / bits;
        if ((count + in_byte - 1) / in_byte > bytes_.size()) return false;
        values.resize(count);
        const unsigned mask = (1U << bits) - 1U;
        for (std::uint64_t i = 0; i < count; ++i) {
            const auto byte = static_cast<unsigned char>(bytes_[i / in_byte]);
            const auto shift = bits * static_cast<unsigned>(i % in_byte);
            values[i] = static_cast<T>((byte >> shift) & mask);
        }
        bytes_.remove_prefix((count + in_byte - 1) / in_byte);
        return true;
    }

  private:
    std::string_view bytes_;
};

static_assert(static_cast<int>(CellUse::kPatched) == 3, "a cell's use takes two bits");

void PutGrid(Writer& out, const MeshGrid& grid) {
    const auto& [u0, v0, du, dv, nu, nv, smooth, alive, cells, nodes] = grid;
    out.Put(u0);
    out.Put(v0);
    out.Put(du);
    out.Put(dv);
    out.Put(nu);
    out.Put(nv);
    out.Put(smooth);
    out.PutPacked(alive, 1);
    out.PutPacked(cells, 2);
    out.PutCount(nodes.size());
    for (const MeshNode& node : nodes) {
        const auto& [wavelength_nm, fields, passage] = node;
        out.Put(wavelength_nm);
        out.PutFloats(fields);
        out.PutFloats(passage);
    }
}

// A used cell has the living corners that everybody who reads it counts on.
bool CellsFit(const MeshGrid& grid) {
    for (int j = 0; j + 1 < grid.nv; ++j) {
        for (int i = 0; i + 1 < grid.nu; ++i) {
            const CellUse use = grid.cells[grid.Cell(i, j)];
            if (use != CellUse::kUsed && use != CellUse::kTriangle) continue;
            const int living = grid.alive[grid.Vertex(i, j)] + grid.alive[grid.Vertex(i + 1, j)] +
                               grid.alive[grid.Vertex(i, j + 1)] +
                               grid.alive[grid.Vertex(i + 1, j + 1)];
            if (living != (use == CellUse::kUsed ? 4 : 3)) return false;
        }
    }
    return true;
}

// `mesh` has its counts already.
bool GetGrid(Reader& in, const GhostMesh& mesh, MeshGrid& grid) {
    if (!(in.Get(grid.u0) && in.Get(grid.v0) && in.Get(grid.du) && in.Get(grid.dv) &&
          in.Get(grid.nu) && in.Get(grid.nv) && in.Get(grid.smooth))) {
        return false;
    }
    if (grid.nu < 2 || grid.nv < 2) return false;
    const auto nu = static_cast<std::uint64_t>(grid.nu), nv = static_cast<std::uint64_t>(grid.nv);
    if (nu * nv > kMostItems) return false;  // both below 2^31: the product fits
    std::uint64_t nodes = 0;
    if (!(in.GetPacked(nu * nv, 1, grid.alive) &&
          in.GetPacked((nu - 1) * (nv - 1), 2, grid.cells) && in.GetCount(sizeof(double), nodes) &&
          CellsFit(grid))) {
        return false;
    }
    grid.nodes.resize(nodes);
    const auto fields = static_cast<std::uint64_t>(mesh.stored_count());
    const auto passage = static_cast<std::uint64_t>(mesh.passage_count());
    return std::all_of(grid.nodes.begin(), grid.nodes.end(), [&](MeshNode& node) {
        return in.Get(node.wavelength_nm) && in.GetFloats(nu * nv * fields, node.fields) &&
               in.GetFloats(nu * nv * passage, node.passage);
    });
}

bool InRange(const std::vector<int>& values, int end) {
    return std::all_of(values.begin(), values.end(),
                       [end](int value) { return value >= 0 && value < end; });
}

bool GetMesh(Reader& in, GhostMesh& mesh) {
    constexpr int kMostInteractions = 1 << 16;
    if (!(in.GetInts(mesh.sequence) && in.Get(mesh.field_rad) && in.Get(mesh.azimuth_rad) &&
          in.Get(mesh.inverse_distance) && in.Get(mesh.stop_crossings) &&
          in.Get(mesh.interactions) && in.GetInts(mesh.rims) && in.GetInts(mesh.absorbing) &&
          in.Get(mesh.rays_traced) && in.Get(mesh.ray_surfaces) && in.Get(mesh.in_doubles))) {
        return false;
    }
    if (mesh.interactions < 0 || mesh.interactions > kMostInteractions || mesh.stop_crossings < 0 ||
        mesh.stop_crossings > mesh.interactions || !InRange(mesh.rims, mesh.interactions) ||
        !InRange(mesh.absorbing, mesh.interactions)) {
        return false;
    }
    constexpr std::size_t kLeastGridBytes = 4 * sizeof(double) + 2 * sizeof(std::uint32_t);
    std::uint64_t grids = 0;
    if (!in.GetCount(kLeastGridBytes, grids)) return false;
    // One at a time: a false count must not take memory for grids that do not come.
    for (std::uint64_t g = 0; g < grids; ++g) {
        if (!GetGrid(in, mesh, mesh.grids.emplace_back())) return false;
        const std::vector<MeshNode>& nodes = mesh.grids.back().nodes;
        if (nodes.empty() || nodes.size() != mesh.grids.front().nodes.size()) return false;
    }
    return in.done();
}

Error Bad(const char* message) {
    return {"bad_mesh_file", message, ""};
}

}  // namespace

std::string EncodeMesh(const Fingerprint& key, const GhostMesh& mesh) {
    const auto& [sequence, field_rad, azimuth_rad, inverse_distance, stop_crossings, interactions,
                 rims, absorbing, grids, in_doubles, rays_traced, ray_surfaces] = mesh;
    Writer payload;
    payload.Reserve(mesh.bytes() + grids.size() * 128 + 1024);
    payload.PutInts(sequence);
    payload.Put(field_rad);
    payload.Put(azimuth_rad);
    payload.Put(inverse_distance);
    payload.Put(stop_crossings);
    payload.Put(interactions);
    payload.PutInts(rims);
    payload.PutInts(absorbing);
    payload.Put(rays_traced);
    payload.Put(ray_surfaces);
    payload.Put(in_doubles);
    payload.PutCount(grids.size());
    for (const MeshGrid& grid : grids) PutGrid(payload, grid);
    const std::string body = payload.Take();

    Writer file;
    file.Reserve(kMeshFileHeaderBytes + body.size());
    file.PutBytes(kMagic);
    file.Put(kMeshFileVersion);
    file.Put(std::uint32_t{0});
    file.Put(key);
    file.PutCount(body.size());
    std::string bytes = file.Take();
    Writer sum;
    sum.Put(Checksum(bytes, body));
    bytes += sum.Take();
    bytes += body;
    return bytes;
}

Result<GhostMesh> DecodeMesh(const Fingerprint& key, std::string_view file) {
    if (file.size() < kMeshFileHeaderBytes) return Bad("it is shorter than a header");
    const std::string_view payload = file.substr(kMeshFileHeaderBytes);
    if (!file.starts_with(kMagic)) return Bad("it is no mesh file");
    Reader head(file.substr(kMagic.size()));
    std::uint32_t version = 0, reserved = 0;
    Fingerprint named, checksum;
    std::uint64_t payload_bytes = 0;
    if (!(head.Get(version) && head.Get(reserved) && head.Get(named) && head.Get(payload_bytes) &&
          head.Get(checksum))) {
        return Bad("it is shorter than a header");
    }
    if (version != kMeshFileVersion || reserved != 0) return Bad("it has another version");
    if (payload_bytes != payload.size()) return Bad("it is cut off or too long");
    if (checksum != Checksum(file.substr(0, kChecksumAt), payload)) {
        return Bad("its checksum is wrong");
    }
    if (named != key) return Bad("it holds another mesh");
    Reader in(payload);
    GhostMesh mesh;
    if (!GetMesh(in, mesh)) return Bad("its sizes do not fit together");
    return mesh;
}

}  // namespace flare
