// SPDX-License-Identifier: Apache-2.0
//
// For each cell: the Bezier nets bound where it lies and which masks cut it; the nets' second
// differences and corner Jacobians say into how many pieces it must be cut; the pieces' corners are
// evaluated row by row. Pieces inside all masks are quadrilaterals; pieces on an edge are clipped
// in pupil space, edge function by edge function, so iris corners and holes stay exact at any grid.
//
// Wavelengths run innermost: their images of one piece lie almost on top of each other, and a sink
// can put them together before it touches the picture.
#include "core/image/ghost_walk.h"

#include <algorithm>
#include <cmath>

#include "core/image/net_shape.h"
#include "core/image/piece_clip.h"
#include "core/image/stop_pass.h"
#include "core/wave/edge_profile.h"

namespace flare {
namespace {

constexpr int kMostCuts = 256;  // pieces along a side of a cell

enum class Mask { kOpen, kCut, kShut };

}  // namespace

struct GhostWalk::Work {
    const GhostLight& ghost;
    const Iris& iris;
    const PictureMap& map;
    const WalkTolerance& tolerance;
    const GhostMesh& mesh;
    std::uint64_t pieces = 0;

    // The cell at hand, at each drawn wavelength.
    struct Sheet {
        bool drawn = false;  // may touch the window and no mask shuts it
        CellSurface surface;
        std::vector<double> row_below, row_above;  // [corner][field of `fields`]
    };
    std::vector<Sheet> sheets;
    const GhostLight::Cell* cell = nullptr;
    std::vector<bool> stop_cut, rim_cut;  // at any wavelength
    std::vector<std::size_t> fields;      // evaluated: sensor, and the masks that cut
    std::vector<std::array<double, 4>> bernstein_u;
    int cuts_u = 1, cuts_v = 1, dead_corner = -1;
    double cell_area = 0.0;
    CellSurface mask_nets;  // of the middle wavelength
    static constexpr std::size_t kMostDepth = 10;
    std::array<std::vector<CornerValues>, kMostDepth> part_values;
    PieceClip clip;
    std::vector<double> light;
    // Edges with fringes near the piece at hand.
    struct PieceEdge {
        CornerValues distance{};
        double per_mm = 0.0, half = 0.0;  // steps of its table
        std::size_t crossing = 0;
    };
    std::vector<PieceEdge> piece_edges;
    std::vector<double> piece_scales;  // [crossing][edge], 0: not known yet

    Work(const GhostLight& g, const Iris& i, const PictureMap& m, const WalkTolerance& t)
        : ghost(g), iris(g.IrisOr(i)), map(m), tolerance(t), mesh(g.surface->mesh()) {
        light.resize(static_cast<std::size_t>(g.channels));
        sheets.resize(g.bands.size());
        if (g.fringes) {
            piece_scales.resize(g.fringes->crossings.size() *
                                static_cast<std::size_t>(iris.edge_count()));
        }
    }

    void Cell(const WalkWindow& window, PieceSink& sink) {
        stop_cut.assign(static_cast<std::size_t>(mesh.stop_crossings), false);
        rim_cut.assign(mesh.rims.size(), false);
        bool any = false;
        for (std::size_t b = 0; b < sheets.size(); ++b) {
            sheets[b].drawn = Prepare(sheets[b], ghost.bands[b], window);
            any = any || sheets[b].drawn;
        }
        if (!any) return;
        ChooseFields();
        ChooseCuts();
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(cell->place.grid)];
        cell_area = grid.du * grid.dv;
        dead_corner = ghost.surface->UseOf(cell->place) == CellUse::kTriangle
                          ? ghost.surface->DeadCorner(cell->place)
                          : -1;
        bernstein_u.resize(static_cast<std::size_t>(cuts_u + 1));
        for (int i = 0; i <= cuts_u; ++i) {
            bernstein_u[static_cast<std::size_t>(i)] = Bernstein(static_cast<double>(i) / cuts_u);
        }
        EvaluateRows(0);
        for (int j = 0; j < cuts_v; ++j) {
            for (Sheet& sheet : sheets) std::swap(sheet.row_below, sheet.row_above);
            EvaluateRows(j + 1);
            for (int i = 0; i < cuts_u; ++i) {
                std::fill(piece_scales.begin(), piece_scales.end(), 0.0);
                for (std::size_t b = 0; b < sheets.size(); ++b) {
                    if (sheets[b].drawn) Piece(b, i, j, window, sink);
                }
                sink.EndOfPiece();
            }
        }
    }

    // Nets in picture and camera coordinates; false if the sheet cannot touch the window or a mask
    // shuts it out.
    bool Prepare(Sheet& sheet, const GhostLight::Band& band, const WalkWindow& window) {
        std::vector<BezierNet>& nets = sheet.surface.nets;
        ghost.surface->Evaluate(cell->place, band.node_weights, 0, 2, sheet.surface);
        MapNets(nets[0], nets[1], map.px_per_x, map.px_per_y, map.offset_px);
        const NetRange x = RangeOf(nets[0]);
        const NetRange y = RangeOf(nets[1]);
        if (x.hi < window.x0 || x.lo > window.x1 || y.hi < window.y0 || y.lo > window.y1)
            return false;
        if (cell->open) return true;

        ghost.surface->Evaluate(cell->place, band.node_weights, 2, mesh.field_count(),
                                sheet.surface);
        for (int c = 0; c < mesh.stop_crossings; ++c) {
            const auto f = static_cast<std::size_t>(mesh.stop_field(c));
            MapNets(nets[f], nets[f + 1], map.stop_per_x, map.stop_per_y, {0.0, 0.0});
            const NetRange sx = RangeOf(nets[f]);
            const NetRange sy = RangeOf(nets[f + 1]);
            if (NearestToOrigin(sx, sy) > iris.outer_radius()) return false;
            if (FarthestFromOrigin(sx, sy) >= iris.inner_radius())
                stop_cut[static_cast<std::size_t>(c)] = true;
        }
        for (std::size_t r = 0; r < rim_cut.size(); ++r) {
            const NetRange rim = RangeOf(nets[RimField(r)]);
            if (rim.lo > 0.0) return false;
            if (rim.hi > 0.0) rim_cut[r] = true;
        }
        return true;
    }

    std::size_t RimField(std::size_t rim) const {
        return static_cast<std::size_t>(mesh.rim_field(static_cast<int>(rim)));
    }

    void ChooseFields() {
        fields = {0, 1};
        for (std::size_t c = 0; c < stop_cut.size(); ++c) {
            if (!stop_cut[c]) continue;
            const auto f = static_cast<std::size_t>(mesh.stop_field(static_cast<int>(c)));
            fields.push_back(f);
            fields.push_back(f + 1);
        }
        for (std::size_t r = 0; r < rim_cut.size(); ++r) {
            if (rim_cut[r]) fields.push_back(RimField(r));
        }
    }

    // The cuts must not depend on the window, so they are taken from the middle wavelength, whether
    // it is drawn here or not.
    void ChooseCuts() {
        Sheet& middle = sheets[sheets.size() / 2];
        const std::vector<BezierNet>& nets = middle.surface.nets;
        const NetShape shape = ShapeOf(nets[0], nets[1]);
        const double density = DensityChange(nets[0], nets[1]) / tolerance.density_step;
        const auto cuts = [&](double bend, double length) {
            // A cubic piece of 1/s of the cell leaves its chord by 6 bend / (8 s^2).
            const double for_place = std::sqrt(0.75 * bend / tolerance.position_px);
            const double for_light = std::min(density, length / tolerance.smallest_px);
            return std::max({1.0, for_place, for_light, length / tolerance.largest_px});
        };
        double u = cuts(shape.bend_u, shape.length_u);
        double v = cuts(shape.bend_v, shape.length_v);
        if (!cell->open) {
            const GhostLight::Band& band = ghost.bands[sheets.size() / 2];
            ghost.surface->Evaluate(cell->place, band.node_weights, 2, mesh.field_count(),
                                    mask_nets);
            for (std::size_t c = 0; c < stop_cut.size(); ++c) {
                const auto f = static_cast<std::size_t>(mesh.stop_field(static_cast<int>(c)));
                const BezierNet& x = mask_nets.nets[f];
                const BezierNet& y = mask_nets.nets[f + 1];
                const double farthest = FarthestFromOrigin(RangeOf(x), RangeOf(y));
                if (Rings(c)) {
                    if (farthest >= iris.inner_radius())
                        CutForFringes(c, ShapeOf(x, y), shape, u, v);
                    continue;
                }
                if (farthest >= iris.edges_inner_radius())
                    CutForMask(ShapeOf(x, y), iris.edges_inner_radius(), u, v);
                if (iris.picture() != nullptr && farthest >= iris.inner_radius())
                    CutForMask(ShapeOf(x, y), iris.outer_radius(), u, v);
            }
            // Near the rim its field is the ratio less 1.
            for (std::size_t r = 0; r < rim_cut.size(); ++r) {
                const BezierNet& rim = mask_nets.nets[RimField(r)];
                if (RangeOf(rim).hi > 0.0) CutForMask(ShapeOf(rim), 1.0, u, v);
            }
        }
        cuts_u = static_cast<int>(std::ceil(std::min(u, static_cast<double>(kMostCuts))));
        cuts_v = static_cast<int>(std::ceil(std::min(v, static_cast<double>(kMostCuts))));
    }

    void CutForMask(const NetShape& shape, double radius, double& u, double& v) const {
        u = std::max(u, shape.length_u / (tolerance.mask_step * radius));
        v = std::max(v, shape.length_v / (tolerance.mask_step * radius));
    }

    bool Rings(std::size_t crossing) const {
        return ghost.fringes && ghost.fringes->crossings[crossing].rings;
    }

    // Pieces that are small against a fringe, or against a pixel.
    void CutForFringes(std::size_t c, const NetShape& stop, const NetShape& shape, double& u,
                       double& v) const {
        constexpr double kStep_t = 0.3;
        // Coarse pictures get coarse pieces; fringes are averaged over each.
        const double coarse = std::max(1.0, 0.4 * tolerance.smallest_px);
        const GhostFringes& fringes = *ghost.fringes;
        const double step_mm =
            coarse * kStep_t *
            std::sqrt(0.5 * fringes.wavelength_mm * fringes.crossings[c].usual_mm);
        u = std::max(u, std::min(stop.length_u / step_mm, shape.length_u / coarse));
        v = std::max(v, std::min(stop.length_v / step_mm, shape.length_v / coarse));
    }

    void EvaluateRows(int row) {
        const std::array<double, 4> bv = Bernstein(static_cast<double>(row) / cuts_v);
        const std::size_t count = fields.size();
        for (Sheet& sheet : sheets) {
            if (!sheet.drawn) continue;
            sheet.row_above.resize(static_cast<std::size_t>(cuts_u + 1) * count);
            for (std::size_t n = 0; n < count; ++n) {
                const BezierNet& net = sheet.surface.nets[fields[n]];
                std::array<double, 4> line{};
                for (std::size_t c = 0; c < 4; ++c) {
                    line[c] = bv[0] * net[c] + bv[1] * net[4 + c] + bv[2] * net[8 + c] +
                              bv[3] * net[12 + c];
                }
                for (std::size_t i = 0; i <= static_cast<std::size_t>(cuts_u); ++i) {
                    const std::array<double, 4>& bu = bernstein_u[i];
                    sheet.row_above[i * count + n] =
                        bu[0] * line[0] + bu[1] * line[1] + bu[2] * line[2] + bu[3] * line[3];
                }
            }
        }
    }

    // Field n at corner k of piece i of the row, going round: (0,0), (1,0), (1,1), (0,1).
    double Value(const Sheet& sheet, int i, int k, std::size_t n) const {
        const std::vector<double>& row = k < 2 ? sheet.row_below : sheet.row_above;
        const auto at = static_cast<std::size_t>(i + (k == 1 || k == 2 ? 1 : 0));
        return row[at * fields.size() + n];
    }

    void Piece(std::size_t b, int i, int j, const WalkWindow& window, PieceSink& sink) {
        const Sheet& sheet = sheets[b];
        CornerPoints px;
        Vec2d lo(1e300), hi(-1e300);
        for (int k = 0; k < 4; ++k) {
            const Vec2d p(Value(sheet, i, k, 0), Value(sheet, i, k, 1));
            px[static_cast<std::size_t>(k)] = p;
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
        if (hi.x < window.x0 || lo.x > window.x1 || hi.y < window.y0 || lo.y > window.y1) return;
        if (!sink.Wants(lo, hi)) return;
        if (iris.picture() != nullptr && fields.size() > 2) {
            PicturedPiece(b, i, j, px, window, sink);
            return;
        }
        clip.Start(px);
        piece_edges.clear();
        const auto value = [&](int k, std::size_t n) { return Value(sheet, i, k, n); };
        if ((fields.size() > 2 || dead_corner >= 0) && !AddMasks(value, i, j, {})) return;
        ++pieces;
        clip.ForEachPart([&](const PiecePart& part) {
            SetLight(b, i, j, part.middle, part.share);
            if (!piece_edges.empty()) {
                const double passed = Passed(b, part);
                for (double& one : light) one *= passed;
            }
            sink.Add(part.px, light, static_cast<int>(b));
        });
    }

    // Part of a piece: the square at (a, b) of the given side, in the piece's own coordinates, and
    // its fields at the corners.
    struct Part {
        double a = 0.0, b = 0.0, side = 1.0;
        int depth = 0;
        std::span<const CornerValues> values;
    };

    // A piece that the iris's picture may cut, in parts that are wholly clear, wholly dark or too
    // small to tell.
    void PicturedPiece(std::size_t b, int i, int j, const CornerPoints& px,
                       const WalkWindow& window, PieceSink& sink) {
        std::vector<CornerValues>& values = part_values[0];
        values.resize(fields.size());
        for (std::size_t n = 0; n < fields.size(); ++n) {
            for (int k = 0; k < 4; ++k)
                values[n][static_cast<std::size_t>(k)] = Value(sheets[b], i, k, n);
        }
        Part whole;
        whole.values = values;
        const double length = std::max({(px[1] - px[0]).length(), (px[2] - px[3]).length(),
                                        (px[3] - px[0]).length(), (px[2] - px[1]).length()});
        AddPart(b, i, j, whole, length, window, sink);
    }

    void AddPart(std::size_t b, int i, int j, const Part& part, double length_px,
                 const WalkWindow& window, PieceSink& sink) {
        constexpr double kSmallest_px = 0.5;
        constexpr float kEven = 0.01F;
        const auto [x0, x1] = std::minmax_element(part.values[0].begin(), part.values[0].end());
        const auto [y0, y1] = std::minmax_element(part.values[1].begin(), part.values[1].end());
        if (*x1 < window.x0 || *x0 > window.x1 || *y1 < window.y0 || *y0 > window.y1) return;
        double passes = 1.0;
        bool even = true;
        ForEachCrossing(part, [&](const StopCorners& at) {
            const StopRange range = PassRange(*iris.picture(), at);
            if (range.dark()) passes = 0.0;
            if (passes == 0.0 || range.clear()) return;
            even = even && range.hi - range.lo <= kEven * range.hi;
        });
        if (passes == 0.0) return;
        if (!even && length_px > kSmallest_px && part.depth + 1 < static_cast<int>(kMostDepth)) {
            for (int quarter = 0; quarter < 4; ++quarter)
                AddPart(b, i, j, Quarter(part, quarter), 0.5 * length_px, window, sink);
            return;
        }
        ForEachCrossing(part,
                        [&](const StopCorners& at) { passes *= PassMean(*iris.picture(), at); });
        if (passes <= 0.0) return;
        CornerPoints px;
        for (std::size_t k = 0; k < 4; ++k) px[k] = {part.values[0][k], part.values[1][k]};
        clip.Start(px);
        const auto value = [&](int k, std::size_t n) {
            return part.values[n][static_cast<std::size_t>(k)];
        };
        if (!AddMasks(value, i, j, part)) return;
        ++pieces;
        clip.ForEachPart([&](const PiecePart& clipped) {
            SetLight(b, i, j, Vec2d(part.a, part.b) + clipped.middle * part.side,
                     clipped.share * part.side * part.side);
            for (double& value_of : light) value_of *= passes;
            sink.Add(clipped.px, light, static_cast<int>(b));
        });
    }

    template <class Use>
    void ForEachCrossing(const Part& part, Use use) const {
        std::size_t n = 2;
        for (std::size_t c = 0; c < stop_cut.size(); ++c) {
            if (!stop_cut[c]) continue;
            StopCorners at;
            for (std::size_t k = 0; k < 4; ++k) at[k] = {part.values[n][k], part.values[n + 1][k]};
            n += 2;
            use(at);
        }
    }

    // Its values stand until the next one of that depth.
    Part Quarter(const Part& whole, int quarter) {
        Part part;
        part.depth = whole.depth + 1;
        part.side = 0.5 * whole.side;
        part.a = whole.a + part.side * (quarter % 2);
        part.b = whole.b + part.side * (quarter / 2);
        std::vector<CornerValues>& values = part_values[static_cast<std::size_t>(part.depth)];
        values.resize(whole.values.size());
        for (std::size_t k = 0; k < 4; ++k) {
            const double u = 0.5 * (quarter % 2 + (k == 1 || k == 2 ? 1 : 0));
            const double v = 0.5 * (quarter / 2 + (k >= 2 ? 1 : 0));
            for (std::size_t n = 0; n < whole.values.size(); ++n) {
                const CornerValues& at = whole.values[n];
                values[n][k] = (1.0 - v) * ((1.0 - u) * at[0] + u * at[1]) +
                               v * ((1.0 - u) * at[3] + u * at[2]);
            }
        }
        part.values = values;
        return part;
    }

    // False if a mask shuts `part` of the piece out; value(k, n) is field n at its corner k.
    template <class At>
    bool AddMasks(At value, int i, int j, const Part& part) {
        std::size_t n = 2;
        for (std::size_t c = 0; c < stop_cut.size(); ++c) {
            if (!stop_cut[c]) continue;
            CornerPoints p;
            double farthest2 = 0.0;
            for (int k = 0; k < 4; ++k) {
                Vec2d& q = p[static_cast<std::size_t>(k)];
                q = {value(k, n), value(k, n + 1)};
                farthest2 = std::max(farthest2, q.length2());
            }
            n += 2;
            if (Rings(c)) {
                if (farthest2 > iris.inner_radius() * iris.inner_radius() && !AddFringes(c, p))
                    return false;
                continue;
            }
            if (farthest2 <= iris.edges_inner_radius() * iris.edges_inner_radius()) continue;
            for (int edge = 0; edge < iris.edge_count(); ++edge) {
                CornerValues values;
                for (std::size_t k = 0; k < 4; ++k) values[k] = iris.EdgeDistance(edge, p[k]);
                if (!clip.AddMask(values)) return false;
            }
        }
        for (std::size_t r = 0; r < rim_cut.size(); ++r) {
            if (!rim_cut[r]) continue;
            CornerValues values;
            for (int k = 0; k < 4; ++k) {
                const double q = std::clamp(value(k, n), -1.0, 1.0 - 1e-9);
                values[static_cast<std::size_t>(k)] = std::sqrt((1.0 + q) / (1.0 - q)) - 1.0;
            }
            ++n;
            if (!clip.AddMask(values)) return false;
        }
        return dead_corner < 0 || clip.AddMask(TriangleEdge(i + part.a, j + part.b, part.side));
    }

    // The edges of a passage that rings, which stands at `stop` at the piece's corners; false if
    // the piece is in the dark.
    bool AddFringes(std::size_t c, const CornerPoints& stop) {
        const GhostFringes& fringes = *ghost.fringes;
        const Vec2d middle = (stop[0] + stop[1] + stop[2] + stop[3]) * 0.25;
        const Vec2d stop_a = (stop[1] - stop[0] + stop[2] - stop[3]) * 0.5;
        const Vec2d stop_b = (stop[3] - stop[0] + stop[2] - stop[1]) * 0.5;
        for (int e = 0; e < iris.edge_count(); ++e) {
            const Iris::Edge& edge = iris.edge(e);
            const Vec2d away = middle - edge.centre;
            const Vec2d normal = edge.radius == 0.0    ? edge.normal
                                 : away.length() > 0.0 ? away.normalized()
                                                       : Vec2d(1.0, 0.0);
            PieceEdge out;
            // Nearly the same for all wavelengths of a piece.
            double& per_mm = piece_scales[c * static_cast<std::size_t>(iris.edge_count()) +
                                          static_cast<std::size_t>(e)];
            if (per_mm == 0.0)
                per_mm = fringes.PerMm(c, middle, normal, iris.EdgeDistance(e, middle));
            double least = 1e300;
            double most = -1e300;
            for (std::size_t k = 0; k < 4; ++k) {
                out.distance[k] = iris.EdgeDistance(e, stop[k]);
                least = std::min(least, out.distance[k] * per_mm);
                most = std::max(most, out.distance[k] * per_mm);
            }
            if (least > fringes.dark_t) return false;
            if (most < -fringes.lit_t) continue;
            const double extent = std::abs(normal.dot(stop_a)) + std::abs(normal.dot(stop_b));
            out.per_mm = per_mm / fringes.step_t;
            out.half = 0.5 * extent * out.per_mm;
            out.crossing = c;
            piece_edges.push_back(out);
        }
        return true;
    }

    // What the fringes let pass of a part of the piece.
    double Passed(std::size_t band, const PiecePart& part) const {
        double product = 1.0;
        const double a = part.middle.x;
        const double b = part.middle.y;
        for (const PieceEdge& edge : piece_edges) {
            const CornerValues& d = edge.distance;
            const double at =
                (1.0 - b) * ((1.0 - a) * d[0] + a * d[1]) + b * ((1.0 - a) * d[3] + a * d[2]);
            const GhostFringes& fringes = *ghost.fringes;
            const double place = fringes.dark_t / fringes.step_t - at * edge.per_mm;
            product *=
                TableMean(fringes.Table(edge.crossing, band), fringes.entries, place, edge.half);
        }
        return product;
    }

    // The line through the two corners next to the dead one: positive on its side.
    CornerValues TriangleEdge(double i, double j, double side) const {
        CornerValues values;
        for (int k = 0; k < 4; ++k) {
            double a = (i + (k == 1 || k == 2 ? side : 0.0)) / cuts_u;
            double b = (j + (k >= 2 ? side : 0.0)) / cuts_v;
            if (dead_corner % 2 == 1) a = 1.0 - a;
            if (dead_corner / 2 == 1) b = 1.0 - b;
            values[static_cast<std::size_t>(k)] = 1.0 - a - b;
        }
        return values;
    }

    // The light on a share of piece (i, j): bilinear in the cell's lattice, at the share's middle.
    void SetLight(std::size_t band, int i, int j, Vec2d middle, double share) {
        const int m = cell->light_cuts;
        const double a = m * (i + middle.x) / cuts_u;
        const double b = m * (j + middle.y) / cuts_v;
        const int la = std::min(static_cast<int>(a), m - 1);
        const int lb = std::min(static_cast<int>(b), m - 1);
        const double fa = a - la;
        const double fb = b - lb;
        const double area =
            ghost.light_unit * cell_area * share / (static_cast<double>(cuts_u) * cuts_v);
        const std::size_t point = ghost.NumbersAPoint();
        const std::size_t row = static_cast<std::size_t>(m + 1) * point;
        const float* const at =
            &ghost.light[cell->light_at * point + static_cast<std::size_t>(lb) * row +
                         static_cast<std::size_t>(la) * point + band * light.size()];
        const auto value = [&](std::size_t n) { return static_cast<double>(at[n]); };
        for (std::size_t c = 0; c < light.size(); ++c) {
            light[c] = area * ((1.0 - fb) * ((1.0 - fa) * value(c) + fa * value(c + point)) +
                               fb * ((1.0 - fa) * value(c + row) + fa * value(c + row + point)));
        }
    }
};

GhostWalk::GhostWalk(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
                     const WalkTolerance& tolerance)
    : work_(std::make_unique<Work>(ghost, iris, map, tolerance)) {}

GhostWalk::~GhostWalk() = default;

void GhostWalk::Cell(const GhostLight::Cell& cell, const WalkWindow& window, PieceSink& sink) {
    work_->cell = &cell;
    work_->Cell(window, sink);
}

std::uint64_t GhostWalk::pieces() const {
    return work_->pieces;
}

}  // namespace flare
