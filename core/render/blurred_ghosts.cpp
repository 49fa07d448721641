// SPDX-License-Identifier: Apache-2.0
#include "core/render/blurred_ghosts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/render/picture.h"

namespace flare {
namespace {

constexpr double kSeen_px = 0.2;      // a source's image of less is a point
constexpr double kFewer = 0.3;        // of directions along a side, when rounding up
constexpr double kWidest_px = 128.0;  // that a kernel may be on its own level
// Less light than this many pixels across is spread by the pixels as much as by its shape, and
// stands where a pixel does: its image is as sharp as the source's, which then has to be.
constexpr double kShape_px = 3.0;
constexpr double kSharp_px = 24.0;
constexpr double kPartsShare = 0.7;  // of the blur, for what parts of a source add up to
constexpr double kAlike_px = 5.0;    // times the tolerance, between images that one kernel serves
constexpr std::size_t kTasksPerBatch = 12;
constexpr std::size_t kPixelsAtOnce = std::size_t{1} << 22;

// The semi-axes of the image of a disc, the smaller one first.
std::array<double, 2> SemiAxes(const GhostMotion& motion, double radius_rad) {
    const Vec2d& u = motion.along_u;
    const Vec2d& v = motion.along_v;
    const double square = u.length2() + v.length2();
    const double area = std::abs(u.x * v.y - u.y * v.x);
    const double spread = std::sqrt(std::max(0.0, square * square - 4.0 * area * area));
    const double larger = std::sqrt(0.5 * (square + spread));
    return {larger > 0.0 ? radius_rad * area / larger : 0.0, radius_rad * larger};
}

int CoarseFor(const std::array<double, 2>& semi, double box_px, double least_px) {
    int coarse = 0;
    while (coarse < kCoarsest) {
        const double scale = std::ldexp(1.0, -coarse - 1);
        const double least = box_px * scale >= kShape_px ? least_px : std::max(least_px, kSharp_px);
        if (semi[0] * scale < least && semi[1] * scale <= 0.5 * kWidest_px) break;
        ++coarse;
    }
    return coarse;
}

int FloorShift(int value, int by) {
    return value >> by;
}

// The pixels of 2^coarse that a window of pixels touches.
PixelWindow Coarser(const PixelWindow& window, int coarse) {
    const int x0 = FloorShift(window.x, coarse);
    const int y0 = FloorShift(window.y, coarse);
    return {x0, y0, FloorShift(window.x + window.width - 1, coarse) + 1 - x0,
            FloorShift(window.y + window.height - 1, coarse) + 1 - y0};
}

// The pixels whose light a kernel brings into the window.
PixelWindow Reached(const PixelWindow& window, const BlurKernel& kernel) {
    return {window.x - (kernel.x0 + kernel.width - 1), window.y - (kernel.y0 + kernel.height - 1),
            window.width + kernel.width - 1, window.height + kernel.height - 1};
}

// Grows a box of pixels, in doubles so that nothing overflows.
struct Box {
    double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;
    void Add(double ax, double ay, double bx, double by) {
        x0 = std::min(x0, ax);
        y0 = std::min(y0, ay);
        x1 = std::max(x1, bx);
        y1 = std::max(y1, by);
    }
    PixelWindow Within(const PixelWindow& w) const {
        const double left = std::max(std::floor(x0), static_cast<double>(w.x));
        const double top = std::max(std::floor(y0), static_cast<double>(w.y));
        const double right = std::min(std::ceil(x1), static_cast<double>(w.x + w.width));
        const double bottom = std::min(std::ceil(y1), static_cast<double>(w.y + w.height));
        if (!(right > left && bottom > top)) return {};
        return {static_cast<int>(left), static_cast<int>(top), static_cast<int>(right - left),
                static_cast<int>(bottom - top)};
    }
};

void AddTiles(const GhostTiles& tiles, Box& box) {
    const auto add = [&](int level, int x, int y) {
        const int size = TileSize(level);
        box.Add(x * size, y * size, (x + 1) * size, (y + 1) * size);
    };
    for (const SmoothTile& tile : tiles.smooth) add(tile.level, tile.x, tile.y);
    for (const EdgeTile& tile : tiles.edges) add(tile.level, tile.x, tile.y);
    if (tiles.any_left) {
        const int size = TileSize(kTileLevels - 1);
        box.Add(tiles.left_x * size, tiles.left_y * size, (tiles.left_x + tiles.left_width) * size,
                (tiles.left_y + tiles.left_height) * size);
    }
}

}  // namespace

// What a source's image on the picture is made by: J, or of a disc, which has no up, the root of
// J J^T, which makes the same.
struct ImageShape {
    Vec2d u{0.0, 0.0}, v{0.0, 0.0};

    double Apart(const ImageShape& other) const {
        const Vec2d a = u - other.u, b = v - other.v;
        return std::max({std::abs(a.x), std::abs(a.y), std::abs(b.x), std::abs(b.y)});
    }
    double Size() const { return std::max(u.length(), v.length()); }
    void Add(const ImageShape& other, double weight) {
        u += other.u * weight;
        v += other.v * weight;
    }
};

namespace {

ImageShape ShapeOf(const GhostMotion& motion, double size, bool disc) {
    const Vec2d u = motion.along_u * size;
    const Vec2d v = motion.along_v * size;
    if (!disc) return {u, v};
    const double xx = u.x * u.x + v.x * v.x;
    const double xy = u.x * u.y + v.x * v.y;
    const double yy = u.y * u.y + v.y * v.y;
    const double area = std::abs(u.x * v.y - u.y * v.x);
    const double root = std::sqrt(xx + yy + 2.0 * area);
    if (!(root > 0.0)) return {};
    return {Vec2d(xx + area, xy) / root, Vec2d(xy, yy + area) / root};
}

}  // namespace

std::vector<BlurChoice> ChooseBlur(std::span<const PlannedGhost> ghosts, const PlacedLight& light,
                                   const QualitySettings& settings) {
    const double radius_rad = 0.5 * light.angular_diameter_rad;
    const double fine = light.detail_rad ? std::min(1.0, *light.detail_rad / radius_rad) : 1.0;
    double all = 0.0;
    double roots = 0.0;
    for (const PlannedGhost& ghost : ghosts) all += ghost.weight * ghost.sample.frame_light;
    const auto misplaced = [&](const PlannedGhost& ghost) {
        if (!ghost.motion || !ghost.motion->known || !(all > 0.0)) return 0.0;
        return ghost.motion->error * ghost.weight * ghost.sample.frame_light / all;
    };
    for (const PlannedGhost& ghost : ghosts) roots += std::sqrt(misplaced(ghost));
    std::vector<BlurChoice> choices;
    for (const PlannedGhost& ghost : ghosts) {
        BlurChoice& choice = choices.emplace_back();
        if (ghost.plain || !ghost.motion || !ghost.motion->known) continue;
        const std::array<double, 2> semi = SemiAxes(*ghost.motion, radius_rad);
        if (semi[1] < kSeen_px) continue;
        // Errors fall with the number of directions; the fewest that keep their sum are those that
        // go with the root of each.
        const double directions = std::sqrt(misplaced(ghost)) * roots / settings.blur_tolerance;
        choice.side = std::clamp(static_cast<int>(std::ceil(std::sqrt(directions) - kFewer)), 1,
                                 settings.most_blur_side);
        // Parts of a source may be less than a pixel: it is their sum that has no detail.
        const double parts = choice.side > 1 ? kPartsShare : 1.0;
        choice.coarse = CoarseFor({semi[0] * parts * fine, semi[1] * parts},
                                  std::min(ghost.sample.box_width_px, ghost.sample.box_height_px),
                                  settings.least_blur_px);
    }
    return choices;
}

// Ghosts that are drawn together, from one direction, and blurred by one kernel.
struct BlurredGhosts::Group {
    std::vector<std::size_t> jobs;
    ImageShape shape;  // of the disc, pixels of 2^coarse
    int coarse = 0;
    double share = 1.0;  // of the source
    PlacedLight light;
    BlurKernel kernel;
    GhostCanvas canvas;
};

BlurredGhosts::BlurredGhosts(const RenderScene& scene, const RenderContext& context,
                             const GhostBuilder& builder, const GhostPlanner& planner,
                             const GhostCanvas& canvas)
    : scene_(scene),
      context_(context),
      builder_(builder),
      planner_(planner),
      canvas_(canvas),
      levels_({scene.window.x - canvas.origin_x, scene.window.y - canvas.origin_y,
               scene.window.width, scene.window.height},
              scene.channel_count()) {}

GhostCanvas BlurredGhosts::CanvasOf(const Group& group) const {
    GhostCanvas canvas = canvas_;
    canvas.coarse = group.coarse;
    canvas.blurred = true;
    const PixelWindow frame{-canvas.origin_x, -canvas.origin_y, scene_.request.image.width,
                            scene_.request.image.height};
    canvas.frame = Reached(Coarser(frame, canvas.coarse), group.kernel);
    canvas.window = Reached(levels_.WindowOf(canvas.coarse), group.kernel);
    if (canvas.tiles) canvas.window = WholeBlocks(canvas.window);
    return canvas;
}

// Those that one direction and all but equal images of a whole disc allow are put together.
std::vector<BlurredGhosts::Group> BlurredGhosts::GroupsOf(const SourceDisc& disc,
                                                          const SourceSquare& part,
                                                          const PlacedLight& light,
                                                          std::span<const Job> jobs,
                                                          Work& work) const {
    std::vector<Group> groups;
    const double radius = 0.5 * light.angular_diameter_rad;
    for (std::size_t n = 0; n < jobs.size() && part.whole(); ++n) {
        const BlurChoice& choice = jobs[n].choice;
        if (choice.side > 1) continue;
        const ImageShape shape =
            ShapeOf(*jobs[n].planned->motion, std::ldexp(1.0, -choice.coarse), disc.round());
        const auto fits = [&](const Group& group) {
            return group.coarse == choice.coarse && group.jobs.size() < kTasksPerBatch &&
                   radius * shape.Apart(group.shape) <
                       scene_.settings.tolerance * (kAlike_px + radius * shape.Size());
        };
        const auto found = std::find_if(groups.begin(), groups.end(), fits);
        Group& group = found != groups.end() ? *found : groups.emplace_back();
        if (group.jobs.empty()) group.shape = shape;
        group.coarse = choice.coarse;
        group.jobs.push_back(n);
    }
    for (Group& group : groups) {
        ImageShape mean;
        for (const std::size_t n : group.jobs) {
            mean.Add(
                ShapeOf(*jobs[n].planned->motion, std::ldexp(1.0, -group.coarse), disc.round()),
                1.0 / static_cast<double>(group.jobs.size()));
        }
        group.light = light;
        group.kernel = KernelOf(disc.CellOf(part, light), {mean.u, mean.v, group.coarse});
    }
    std::vector<Group> single = PartsOf(disc, part, light, jobs, work);
    std::move(single.begin(), single.end(), std::back_inserter(groups));
    for (Group& group : groups) group.canvas = CanvasOf(group);
    return groups;
}

// One ghost each, from one direction.
std::vector<BlurredGhosts::Group> BlurredGhosts::PartsOf(const SourceDisc& disc,
                                                         const SourceSquare& part,
                                                         const PlacedLight& light,
                                                         std::span<const Job> jobs,
                                                         Work& work) const {
    std::vector<Group> groups;
    std::vector<SourceSquare> squares;
    for (std::size_t n = 0; n < jobs.size(); ++n) {
        const int side = jobs[n].choice.side;
        if (side == 1 && part.whole()) continue;
        for (int k = 0; k < side * side; ++k) {
            const SourceSquare square = part.Part(k % side, k / side, side);
            const double share = disc.ShareOf(square);
            if (!(share > 0.0)) continue;
            squares.push_back(square);
            Group& group = groups.emplace_back();
            group.jobs = {n};
            group.coarse = jobs[n].choice.coarse;
            group.share = share / disc.ShareOf(part);
        }
    }
    std::vector<std::uint64_t> rays(groups.size());
    context_.threads.For(static_cast<int>(groups.size()), [&](int i) {
        const auto g = static_cast<std::size_t>(i);
        Group& group = groups[g];
        const Job& job = jobs[group.jobs.front()];
        group.light = light;
        GhostMotion motion = *job.planned->motion;
        const PlacedLight* seen_from = &light;
        if (job.choice.side > 1) {
            group.light = disc.LightOf(squares[g]);
            const GhostMotion own = planner_.MotionAlone(group.light, *job.sequence);
            rays[g] = own.rays;
            if (own.known) {
                motion = own;
                seen_from = &group.light;
            }
        }
        const double size = std::ldexp(1.0, -group.coarse);
        group.kernel = KernelOf(disc.CellOf(squares[g], *seen_from),
                                {motion.along_u * size, motion.along_v * size, group.coarse});
    });
    for (const std::uint64_t r : rays) work.sampled_rays += r;
    return groups;
}

std::vector<BlurredGhosts::Drawn> BlurredGhosts::Add(const SourceDisc& disc,
                                                     const SourceSquare& part,
                                                     const PlacedLight& light,
                                                     std::span<const Job> jobs, bool with_flux,
                                                     Work& work) {
    std::vector<Drawn> drawn(jobs.size());
    const std::vector<Group> groups = GroupsOf(disc, part, light, jobs, work);
    for (std::size_t first = 0; first < groups.size();) {
        // As many at once as memory allows.
        std::size_t count = 0, ghosts = 0, pixels = 0;
        while (first + count < groups.size()) {
            const Group& next = groups[first + count];
            ghosts += next.jobs.size();
            pixels += next.canvas.window.pixels();
            if (count > 0 && (ghosts > kTasksPerBatch || pixels > kPixelsAtOnce)) break;
            ++count;
        }
        AddGroups(std::span(groups).subspan(first, count), jobs, with_flux, drawn, work);
        if (context_.cancel.cancelled()) break;
        first += count;
    }
    return drawn;
}

void BlurredGhosts::AddGroups(std::span<const Group> groups, std::span<const Job> jobs,
                              bool with_flux, std::vector<Drawn>& drawn, Work& work) {
    std::vector<std::pair<std::size_t, std::size_t>> tasks;  // group, job
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for (const std::size_t job : groups[g].jobs) tasks.emplace_back(g, job);
    }
    const double t0 = context_.now_ms();
    std::vector<GhostBuilder::Built> built(tasks.size());
    context_.threads.For(static_cast<int>(tasks.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        const Group& group = groups[tasks[n].first];
        const Job& job = jobs[tasks[n].second];
        built[n] = builder_.Build(group.light, *job.sequence, job.planned->weight, with_flux,
                                  group.canvas);
    });
    const double t1 = context_.now_ms();
    work.mesh_ms += t1 - t0;
    std::vector<std::vector<TiledGhost>> ghosts(groups.size());
    for (std::size_t n = 0; n < tasks.size(); ++n) {
        Drawn& of = drawn[tasks[n].second];
        of.miss = built[n].miss;
        JoinRinging(built[n].ringing, of.ringing);
        of.dispersion_step_px = built[n].dispersion_step_px;
        of.flux_mm2 += groups[tasks[n].first].share * built[n].flux_mm2;
        work.Add(built[n].work);
        if (built[n].ghost.light.cells.empty()) continue;
        ghosts[tasks[n].first].push_back(std::move(built[n].ghost));
    }
    if (context_.cancel.cancelled()) return;
    std::vector<LightPlanes> planes(groups.size());
    std::vector<Work> works(groups.size());
    context_.threads.For(static_cast<int>(groups.size()), [&](int i) {
        const auto g = static_cast<std::size_t>(i);
        planes[g] = Draw(groups[g], std::move(ghosts[g]), works[g]);
    });
    for (std::size_t g = 0; g < groups.size(); ++g) {
        work.Add(works[g]);
        if (planes[g].channels.empty()) continue;
        AddBlurred(planes[g], groups[g].kernel, levels_.Level(groups[g].coarse), context_.threads);
    }
    work.raster_ms += context_.now_ms() - t1;
}

LightPlanes BlurredGhosts::Draw(const Group& group, std::vector<TiledGhost> ghosts,
                                Work& work) const {
    Box box;
    for (const TiledGhost& ghost : ghosts) {
        if (group.canvas.tiles) {
            if (ghost.tiles) AddTiles(*ghost.tiles, box);
            continue;
        }
        for (const GhostLight::Cell& cell : ghost.light.cells)
            box.Add(cell.x0, cell.y0, cell.x1, cell.y1);
    }
    LightPlanes planes;
    planes.window = box.Within(group.canvas.window);
    if (planes.window.width == 0) return planes;
    planes.window = WithBlurMargin(planes.window, group.kernel);
    const PictureMap map = group.canvas.MapOnto(MapOf(scene_.request, group.light.pose));
    const auto count = [&](const auto& drawn) {
        work.polygons += drawn.pieces;
        work.fragments += drawn.fragments;
    };
    if (group.canvas.tiles) {
        TilePicture picture(planes.window, 0, 0, group.canvas.unit);
        count(picture.Draw(ghosts, scene_.iris, map, scene_.settings.walk, context_.threads,
                           context_.cancel));
        for (std::vector<float>& channel : picture.Resolve(1.0, context_.threads))
            planes.channels.push_back(std::move(channel));
        return planes;
    }
    Picture picture(planes.window,
                    scene_.spectral() ? static_cast<int>(scene_.channel_count()) : 0);
    std::vector<GhostLight> lights;
    for (TiledGhost& ghost : ghosts) lights.push_back(std::move(ghost.light));
    count(picture.Draw(lights, scene_.iris, map, scene_.settings.walk, context_.threads,
                       context_.cancel));
    for (int c = 0; c < picture.channel_count(); ++c)
        planes.channels.push_back(picture.Channel(c, 1.0));
    return planes;
}

}  // namespace flare
