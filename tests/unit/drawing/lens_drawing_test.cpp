// SPDX-License-Identifier: Apache-2.0
//
// Drawings are read back as XML: what stands in them is compared with the prescription and with
// rays traced anew from where the drawing starts them.
#include "core/drawing/lens_drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/base/units.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"
#include "tests/support/xml_document.h"

namespace flare {
namespace {

using testing::Assemble;
using testing::BuildLens;
using testing::LibraryPrescription;
using testing::SeedLens;
using testing::Sphere;
using testing::Stop;
using testing::XmlElement;
using testing::XmlReader;

// Coordinates are written to 1e-4 mm; a lens may magnify half of that some times.
constexpr double kWritten_mm = 1e-4;
constexpr double kTraced_mm = 2e-3;

XmlElement Drawn(const Lens& lens, const DrawingOptions& options) {
    const Result<std::string> svg = DrawLens(lens, options);
    EXPECT_TRUE(svg.ok());
    const auto root = XmlReader::Read(*svg);
    EXPECT_TRUE(root.has_value()) << svg->substr(0, 2000);
    return root.value_or(XmlElement{});
}

// Every number of the text, in order.
std::vector<double> Numbers(const std::string& text) {
    std::vector<double> numbers;
    const char* at = text.c_str();
    while (*at != '\0') {
        char* end = nullptr;
        const double value = std::strtod(at, &end);
        if (end == at) {
            ++at;
            continue;
        }
        numbers.push_back(value);
        at = end;
    }
    return numbers;
}

std::vector<Vec2d> PointsOf(const XmlElement& element) {
    const std::vector<double> numbers = Numbers(element.Attribute("points"));
    EXPECT_EQ(numbers.size() % 2, 0U);
    std::vector<Vec2d> points;
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
        points.emplace_back(numbers[i], numbers[i + 1]);
    }
    return points;
}

void ExpectFiniteNumbers(const XmlElement& element) {
    for (const auto& [key, value] : element.attributes) {
        static const std::vector<std::string> kNumeric{
            "points",          "x", "y", "width", "height", "viewBox", "stroke-width", "transform",
            "stroke-dasharray"};
        if (std::find(kNumeric.begin(), kNumeric.end(), key) == kNumeric.end()) continue;
        EXPECT_EQ(value.find("nan"), std::string::npos) << value;
        EXPECT_EQ(value.find("inf"), std::string::npos) << value;
        for (const double number : Numbers(value)) EXPECT_LT(std::abs(number), 1e6) << key;
    }
    for (const XmlElement& child : element.children) ExpectFiniteNumbers(child);
}

int GlassGaps(const Lens& lens) {
    const auto& surfaces = lens.prescription().surfaces;
    return static_cast<int>(
        std::count_if(surfaces.begin(), surfaces.end(), [](const SurfacePrescription& surface) {
            return surface.glass.has_value() || surface.nd.value_or(1.0) != 1.0;
        }));
}

// Does the leg end on surface `index`, as the section shows it?
void ExpectOnSurface(const Lens& lens, int index, Vec2d p) {
    if (index == lens.sensor_index()) {
        EXPECT_NEAR(p.x, lens.sensor_z_mm(), kWritten_mm);
        return;
    }
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(index)];
    EXPECT_NEAR(p.x, surface.vertex_z_mm + surface.shape.Sag(0.0, p.y), 10 * kWritten_mm);
}

// Each drawn ray of a ghost against one traced from its drawn start along the light's direction.
void ExpectGhostIsTraced(const Lens& lens, const XmlElement& ghost, const BounceSequence& sequence,
                         double field_deg) {
    const InteractionList list = WriteOut(lens, sequence, kLineD);
    const double field = RadiansFromDegrees(field_deg);
    const auto rays = ghost.OfClass("ray");
    EXPECT_GE(rays.size(), 3U);
    for (const XmlElement* ray : rays) {
        const auto legs = ray->OfClass("leg");
        ASSERT_EQ(legs.size(), sequence.size() + 1);
        std::vector<Vec2d> way = PointsOf(*legs[0]);
        for (std::size_t leg = 1; leg < legs.size(); ++leg) {
            ExpectOnSurface(lens, sequence[leg - 1], way.back());
            const std::vector<Vec2d> next = PointsOf(*legs[leg]);
            ASSERT_EQ(next.front(), way.back());
            // Light turns back: z runs the other way.
            EXPECT_EQ(next.back().x < next.front().x, leg % 2 == 1);
            way.insert(way.end(), next.begin() + 1, next.end());
        }
        EXPECT_NEAR(way.back().x, lens.sensor_z_mm(), kWritten_mm);

        RayRecord record;
        const Ray start{{0.0, way[0].y, way[0].x}, {0.0, -std::sin(field), std::cos(field)}};
        const TraceResult traced = TraceRay(list, start, {false, nullptr, true}, &record);
        ASSERT_EQ(traced.fate, RayFate::kArrived);
        ASSERT_EQ(way.size(), record.points.size() + 2);
        for (std::size_t i = 0; i < record.points.size(); ++i) {
            EXPECT_NEAR(way[i + 1].x, record.points[i].z, kTraced_mm);
            EXPECT_NEAR(way[i + 1].y, record.points[i].y, kTraced_mm);
            EXPECT_LE(record.rim_ratio2[i], 1.001);
        }
        EXPECT_NEAR(way.back().y, traced.sensor_mm.y, kTraced_mm);
    }
}

TEST(DrawLens, DrawsEveryPieceOfGlassOnce) {
    const auto lens = BuildLens(SeedLens());
    const XmlElement root = Drawn(*lens, {});
    EXPECT_EQ(root.name, "svg");
    const auto elements = root.OfClass("element");
    EXPECT_EQ(elements.size(), 6U);
    EXPECT_EQ(static_cast<int>(elements.size()), GlassGaps(*lens));
    // Equal glass has equal colour, another another.
    EXPECT_EQ(elements[0]->Attribute("fill"), elements[1]->Attribute("fill"));
    EXPECT_NE(elements[0]->Attribute("fill"), elements[2]->Attribute("fill"));
    EXPECT_EQ(root.OfClass("stop").size(), 2U);
    EXPECT_EQ(root.OfClass("sensor").size(), 1U);
    EXPECT_EQ(root.OfClass("axial").size(), 1U);
}

// A sensor so high that no ghost leaves the picture.
Prescription RoomySeedLens() {
    Prescription file = SeedLens();
    file.design_image_circle_mm = 100.0;
    return file;
}

TEST(DrawLens, TheGhostsPathIsTheTracedOne) {
    const auto lens = BuildLens(RoomySeedLens());
    DrawingOptions options;
    options.ghosts = {{9, 1}, {3, 0}};
    options.field_deg = 5.0;
    const XmlElement root = Drawn(*lens, options);
    const auto ghosts = root.OfClass("ghost");
    ASSERT_EQ(ghosts.size(), 2U);
    EXPECT_EQ(ghosts[0]->Attribute("data-sequence"), "(9,1)");
    EXPECT_NE(ghosts[0]->Attribute("stroke"), ghosts[1]->Attribute("stroke"));
    for (std::size_t k = 0; k < 2; ++k) {
        ExpectGhostIsTraced(*lens, *ghosts[k], options.ghosts[k], 5.0);
        EXPECT_EQ(ghosts[k]->OfClass("reflector").size(), 2U);
    }
}

TEST(DrawLens, CutsRaysThatLeaveThePictureWhereTheyDo) {
    Prescription file = SeedLens();
    DrawingOptions options;
    options.ghosts = {{3, 0}};
    const auto ends = [&](const XmlElement& root) {
        std::vector<std::vector<Vec2d>> found;
        for (const XmlElement* ray : root.OfClass("ray")) {
            found.push_back(PointsOf(*ray->OfClass("leg").back()));
        }
        return found;
    };
    const auto small = BuildLens(file);
    const auto cut = ends(Drawn(*small, options));
    const auto whole = ends(Drawn(*BuildLens(RoomySeedLens()), options));
    ASSERT_EQ(cut.size(), whole.size());
    const double highest = std::max({12.6, 0.5 * small->first_order().entrance.diameter_mm,
                                     0.5 * small->first_order().exit.diameter_mm});
    int shortened = 0;
    for (std::size_t i = 0; i < cut.size(); ++i) {
        const Vec2d end = cut[i].back();
        const Vec2d from = whole[i][whole[i].size() - 2];
        const Vec2d to = whole[i].back();
        EXPECT_LE(std::abs(end.y), 1.3 * highest + kWritten_mm);
        if (end == to) continue;
        ++shortened;
        EXPECT_LT(end.x, small->sensor_z_mm());
        EXPECT_NEAR((end.y - from.y) * (to.x - from.x), (to.y - from.y) * (end.x - from.x), 0.05);
    }
    EXPECT_GT(shortened, 0);
}

TEST(DrawLens, FollowsFourReflectionsAndTheSensorsOwn) {
    Prescription file = RoomySeedLens();
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.semi_diameter_mm = 21.6;
    sensor.reflectance = 0.1;
    file.surfaces.push_back(sensor);
    const auto lens = BuildLens(file);
    DrawingOptions options;
    options.ghosts = {{3, 2, 4, 1}, {lens->sensor_index(), 10}};
    options.field_deg = 2.0;
    const XmlElement root = Drawn(*lens, options);
    const auto ghosts = root.OfClass("ghost");
    ASSERT_EQ(ghosts.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
        ExpectGhostIsTraced(*lens, *ghosts[k], options.ghosts[k], 2.0);
    }
    EXPECT_FALSE(root.OfClass("sensor-back").empty());
}

TEST(DrawLens, StandsToScaleOnTheSheet) {
    const auto lens = BuildLens(SeedLens());
    const XmlElement root = Drawn(*lens, {});
    const auto scaled = root.OfClass("scaled");
    ASSERT_EQ(scaled.size(), 1U);
    const std::vector<double> transform = Numbers(scaled[0]->Attribute("transform"));
    ASSERT_EQ(transform.size(), 4U);
    EXPECT_EQ(transform[2], -transform[3]);
    const std::vector<double> sheet = Numbers(root.Attribute("viewBox"));
    ASSERT_EQ(sheet.size(), 4U);
    const auto all_within = [&](const char* kind) {
        for (const XmlElement* element : scaled[0]->OfClass(kind)) {
            for (const Vec2d& p : PointsOf(*element)) {
                EXPECT_GE(transform[0] + transform[2] * p.x, 0.0);
                EXPECT_LE(transform[0] + transform[2] * p.x, sheet[2]);
                EXPECT_GE(transform[1] + transform[3] * p.y, 0.0);
                EXPECT_LE(transform[1] + transform[3] * p.y, sheet[3]);
            }
        }
    };
    for (const char* kind : {"element", "sensor", "stop", "upper", "lower", "pupil"}) {
        all_within(kind);
    }
    // The bar is as long on the sheet as it says in mm.
    const auto bars = root.OfClass("scale-bar");
    ASSERT_EQ(bars.size(), 1U);
    const std::vector<Vec2d> bar = PointsOf(*bars[0]);
    double says_mm = 0.0;
    for (const XmlElement& child : root.children) {
        const std::size_t unit = child.text.find(" mm");
        if (child.name == "text" && unit + 3 == child.text.size()) says_mm = Numbers(child.text)[0];
    }
    EXPECT_NEAR((bar.back().x - bar.front().x) / transform[2], says_mm, 1e-3);
    const double digit = says_mm / std::pow(10.0, std::floor(std::log10(says_mm)));
    EXPECT_TRUE(digit == 1.0 || digit == 2.0 || digit == 5.0) << says_mm;
}

TEST(DrawLens, TheStopIsDrawnAtItsFNumber) {
    const auto lens = BuildLens(SeedLens());
    DrawingOptions options;
    options.f_number = 8.0;
    const XmlElement root = Drawn(*lens, options);
    // N = EFL / entrance pupil; the pupil is the stop's image, so both scale alike.
    const double open = lens->first_order().f_number;
    const double opening = 8.55 * open / 8.0;
    for (const XmlElement* bar : root.OfClass("stop")) {
        EXPECT_NEAR(std::abs(PointsOf(*bar)[0].y), opening, 1e-3);
    }
    const auto pupils = root.OfClass("pupil");
    ASSERT_EQ(pupils.size(), 4U);
    const FirstOrder& first = lens->first_order();
    EXPECT_NEAR(PointsOf(*pupils[0])[2].x, first.entrance.z_mm, kWritten_mm);
    EXPECT_NEAR(PointsOf(*pupils[0])[2].y, 0.5 * first.efl_mm / 8.0, 1e-3);
    EXPECT_NEAR(PointsOf(*pupils[2])[2].x, first.exit.z_mm, kWritten_mm);
}

TEST(DrawLens, AnAnamorphicLensHasBothSections) {
    Prescription file = Assemble("anamorphic", {
                                                   Sphere(-100.0, 3.0, 1.5, 0.0, 14.0),
                                                   Sphere(0.0, 20.0, 1.0, 0.0, 14.0),
                                                   Stop(2.0, 5.0),
                                                   Sphere(60.0, 4.0, 1.6, 0.0, 9.0),
                                                   Sphere(-60.0, 0.0, 1.0, 0.0, 9.0),
                                               });
    file.surfaces[0].kind = SurfaceKind::kCylinderX;
    file.surfaces.back().gap_mm = 55.0;
    file.surfaces.back().gap_given = true;
    file.design_image_circle_mm = 20.0;
    const auto lens = BuildLens(file);
    const XmlElement root = Drawn(*lens, {});
    const auto scaled = root.OfClass("scaled");
    ASSERT_EQ(scaled.size(), 2U);
    EXPECT_EQ(root.OfClass("element").size(), 4U);
    // The front is curved in x, drawn first, and flat in y.
    const auto most_left = [](const XmlElement& section) {
        double z = 0.0;
        for (const Vec2d& p : PointsOf(*section.OfClass("element")[0])) z = std::min(z, p.x);
        return z;
    };
    EXPECT_NEAR(most_left(*scaled[0]), -100.0 + std::sqrt(10000.0 - 196.0), kWritten_mm);
    EXPECT_EQ(most_left(*scaled[1]), 0.0);
    // The field beam ends at 0.7 of the image circle's radius in both.
    for (const XmlElement* section : scaled) {
        const auto chief = section->OfClass("chief");
        ASSERT_EQ(chief.size(), 1U);
        EXPECT_NEAR(std::abs(PointsOf(*chief[0]).back().y), 7.0, 2 * kWritten_mm);
    }
}

TEST(DrawLens, SaysTheStateAndWhatPassesNowhere) {
    const auto lens = BuildLens(SeedLens());
    DrawingOptions options;
    options.state = {1.5, 72.0};
    options.field_deg = 80.0;
    options.ghosts = {{9, 1}};
    const std::string svg = *DrawLens(*lens, options);
    EXPECT_NE(svg.find("zoom at 72 mm"), std::string::npos);
    EXPECT_NE(svg.find("focus at 1.5 m"), std::string::npos);
    EXPECT_NE(svg.find("no light passes"), std::string::npos);
    EXPECT_NE(svg.find("no ray of it passes"), std::string::npos);
    EXPECT_EQ(DrawLens(*lens, {})->find("passes"), std::string::npos);
}

TEST(DrawLens, EveryLensOfTheLibraryInAnyStateIsSoundXml) {
    int lenses = 0;
    for (const auto& entry : std::filesystem::directory_iterator(FLARE_SOURCE_DIR "/lenses")) {
        if (entry.path().extension() != ".toml") continue;
        ++lenses;
        SCOPED_TRACE(entry.path().stem().string());
        Prescription file = LibraryPrescription(entry.path().stem().string());
        // Coatings bend no ray.
        file.default_coating = "bare";
        for (SurfacePrescription& surface : file.surfaces) surface.coating.reset();
        const auto base = BuildLens(file);
        const auto near = SetState(base, {2.0, 135.0});
        ASSERT_TRUE(near.ok());
        for (const auto& lens : {base, near->lens}) {
            DrawingOptions options;
            const XmlElement plain = Drawn(*lens, options);
            ExpectFiniteNumbers(plain);
            const std::size_t sections = lens->rotational() ? 1 : 2;
            EXPECT_EQ(plain.OfClass("scaled").size(), sections);
            EXPECT_EQ(plain.OfClass("element").size(),
                      sections * static_cast<std::size_t>(GlassGaps(*lens)));
            EXPECT_EQ(plain.OfClass("upper").size(), 2 * sections);
            const std::vector<BounceSequence> all = TwoReflectionSequences(*lens);
            options.ghosts = {all.front(), all[all.size() / 2], all.back()};
            options.field_deg = 1.0;
            ExpectFiniteNumbers(Drawn(*lens, options));
        }
    }
    EXPECT_GE(lenses, 12);
}

TEST(DrawLens, ALensWithoutPowerOrImageCircleIsDrawnToo) {
    Prescription file = Assemble("plate <&>", {Stop(5.0, 4.0), Sphere(0.0, 3.0, 1.5, 0.0, 8.0),
                                               Sphere(0.0, 0.0, 1.0, 0.0, 8.0)});
    file.surfaces.back().gap_mm = 20.0;
    file.surfaces.back().gap_given = true;
    const auto lens = BuildLens(file);
    const XmlElement root = Drawn(*lens, {});
    ExpectFiniteNumbers(root);
    ASSERT_FALSE(root.children.empty());
    EXPECT_EQ(root.children[0].name, "title");
    EXPECT_EQ(root.children[0].text, "plate <&>");
}

TEST(DrawLens, GivesTheSameBytesTwice) {
    DrawingOptions options;
    options.ghosts = {{9, 1}};
    options.field_deg = 5.0;
    EXPECT_EQ(*DrawLens(*BuildLens(SeedLens()), options),
              *DrawLens(*BuildLens(SeedLens()), options));
}

TEST(DrawLens, RefusesWhatItCannotDraw) {
    const auto lens = BuildLens(SeedLens());
    const auto where = [&](const DrawingOptions& options) {
        const Result<std::string> svg = DrawLens(*lens, options);
        return svg.ok() ? std::string("drawn") : svg.error().code + " " + svg.error().where;
    };
    DrawingOptions options;
    options.ghosts = {{9, 1}, {1, 9}};
    EXPECT_EQ(where(options), "bad_value /ghosts/1");
    options.ghosts = {{}};
    EXPECT_EQ(where(options), "bad_value /ghosts/0");
    options.ghosts = {{9, 5}};  // the stop
    EXPECT_EQ(where(options), "bad_value /ghosts/0");
    options.ghosts.assign(kMostDrawnGhosts + 1, {9, 1});
    EXPECT_EQ(where(options), "bad_value /ghosts");
    options.ghosts.assign(kMostDrawnGhosts, {9, 1});
    EXPECT_EQ(where(options), "drawn");
    options.field_deg = 180.5;
    EXPECT_EQ(where(options), "bad_value /field_deg");
    options.field_deg = std::nan("");
    EXPECT_EQ(where(options), "bad_value /field_deg");
    options.field_deg.reset();
    options.f_number = 0.0;
    EXPECT_EQ(where(options), "bad_value /f_number");
}

}  // namespace
}  // namespace flare
