// SPDX-License-Identifier: Apache-2.0
//
// Files that the other programs' own projects ship, typed off (and shortened to what is read) with
// their source. The focal lengths were worked out from the numbers by a script of ten lines outside
// this program, named glass by the formula of the maker.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include "core/prescription/prescription_check.h"
#include "server/translate/lens_import_json.h"
#include "tests/support/foreign_lens_files.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

// mmp/pbrt-v4-scenes, lenses/telephoto.dat: Sigler's telephoto, Modern Lens Design p. 175. The gap
// stands in front of the surface.
constexpr const char* kPbrtTelephoto = R"(# SIGLER Super achromate telephoto, EFL=254mm, F/5.6
# MLD, Page 175
# radius	axpos	N	aperture
  21.851	0		1.529	19.0
 -34.546	5.008	1.599	17.8
 108.705	1.502	1.0		16.6
   0		1.127	0		16.2
 -12.852   26.965	1.613	12.6
  19.813	1.502	1.603	13.4
 -20.378	5.008	1.0		14.8
)";

// appleseedhq/appleseed, sandbox/lenses/petzval-kodak.txt (MIT): US 2,500,046. The gap stands
// behind; the plane of air in surface 2 is no stop, that of index 0 is.
constexpr const char* kAppleseedPetzval =
    R"(// petzval-type photographic objective US2500046A (1948)
70.97	15.0	1.523	23
-56.79	4.5	1.617	23
0	24.0	1	23
0	25.3	0	18
119.91	3.8	1.649	15
40.87	0.9	1	15
46.87	7.4	1.697	15
-282.05	56.5	1	15
)";

// The table of US 2,673,491 as lens courses print it, halved to 50 mm (Modern Lens Design p. 312).
// Its apertures are diameters, and of the stop only the plane is seen.
constexpr const char* kPrintedTable = R"(# D-GAUSS F/2 22deg HFOV
# US patent 2,673,491 Tronnier
Radius	Axpos	N	Aperture	v-no
29.475	3.76	1.67	25.2	47.1
84.83	0.12	1	25.2	-
19.275	4.025	1.67	23	47.1
40.77	3.275	1.699	23	30.1
12.75	5.705	1	18	-
0	4.5	1	17.1	-
-14.495	1.18	1.603	17	38.4
40.77	6.065	1.658	20	57.0
-20.385	0.19	1	20	-
437.065	3.22	1.717	20	48.1
-39.73	0	1	20	-
)";

// LocalStarlight/flaresim_nuke, lenses/lens_files/Canon_85mm_F1.24.lens (MIT): semi_ap holds
// diameters.
constexpr const char* kFlareSimCanon = R"(# US 8,773,783 Example 1
# Patent: US008773783
# 17 surfaces, 10 glass elements, f/1.2

name: US 8,773,783 Example 1
focal_length: 85.00

surfaces:
# radius       thickness    ior      abbe     semi_ap   coating
  131.8110       4.8300       1.84666  23.80    68.550    1
  449.8450       0.1500       1.00000  0.00     68.160    0
  48.3340        13.3000      1.59522  67.70    64.520    1
  129.4020       0.1500       1.00000  0.00     60.800    0
  44.3700        15.4200      1.59522  67.70    54.650    1
  294.0680       0.8800       1.76499  15.00    46.230    1
  1408.1440      2.2500       1.84666  23.80    46.060    1
  24.5970        14.1200      1.00000  0.00     35.900    0
  stop           8.9900       1.00000  0.00     33.980    0
  -27.4890       3.8400       1.76182  26.50    32.920    1
  132.7190       10.5000      1.91082  35.30    37.820    1
  -43.3210       0.1500       1.00000  0.00     39.560    0
  253.9160       3.5800       1.90366  31.30    38.670    1
  -97.6090       0.9900       1.00000  0.00     38.530    0
  198.4610       1.5400       1.65412  39.70    38.570    1
  62.9980        3.5200       1.72916  54.70    38.850    1
  763.4040       38.3500      1.00000  0.00     38.880    0
)";

// beatreichenbach/realflare, Tronnier_color-heliar.json (MIT).
constexpr const char* kRealflareHeliar = R"({"name": "Color Heliar", "year": 1950,
"patent_number": "2645156", "notes": "", "focal_length": 105, "fstop": 3.5, "aperture_index": 5,
"lens_elements": [
{"radius": 30.809, "distance": 7.702, "refractive_index": 1.651, "abbe_nr": 58.6, "height": 14.5},
{"radius": -89.35, "distance": 1.855, "refractive_index": 1.603, "abbe_nr": 38.4, "height": 14.5},
{"radius": 580.0, "distance": 3.521, "refractive_index": 1.0, "abbe_nr": 0.0, "height": 14.5},
{"radius": -80.063, "distance": 1.849, "refractive_index": 1.643, "abbe_nr": 47.9, "height": 12.3},
{"radius": 28.34, "distance": 4.625, "refractive_index": 1.0, "abbe_nr": 0.0, "height": 12.0},
{"radius": 0.0, "distance": 2.554, "refractive_index": 1.0, "abbe_nr": 0.0, "height": 11.6},
{"radius": 0.0, "distance": 1.849, "refractive_index": 1.582, "abbe_nr": 40.6, "height": 12.3},
{"radius": 32.19, "distance": 7.271, "refractive_index": 1.693, "abbe_nr": 53.5, "height": 12.3},
{"radius": -52.99, "distance": 92.03, "refractive_index": 1.0, "abbe_nr": 0.0, "height": 12.3}]})";

// zpelgrims/lentil, polynomial-optics/database, 0007 (MIT): Cooke Speed Panchro, GB 157,040.
constexpr const char* kLentilPanchro = R"({"company": "cooke", "product-name": "speed-panchro",
"focal-length-mm-patent": 25.4, "fstop": {"unscaled": 1.9965}, "patent-number": "GB157040A",
"year": 1920, "notes-to-self": "", "optical-elements-patent": [
{"abbe": 59, "aspherical-equation": null, "housing-radius": 6.5, "ior": 1.6118,
 "lens-geometry": "spherical", "material": "abbe", "radius": 16.59, "thickness": 2.1234},
{"abbe": null, "housing-radius": 6.5, "ior": null,
 "lens-geometry": "spherical", "material": "air", "radius": 76.809, "thickness": 0.35306},
{"abbe": 59.0, "housing-radius": 6.0, "ior": 1.6118,
 "lens-geometry": "spherical", "material": "abbe", "radius": 11.3309, "thickness": 2.4765},
{"abbe": 41.0, "housing-radius": 6.0, "ior": 1.576,
 "lens-geometry": "spherical", "material": "abbe", "radius": 100000.0, "thickness": 1.06172},
{"abbe": null, "housing-radius": 4.65, "ior": null,
 "lens-geometry": "spherical", "material": "air", "radius": 7.1856, "thickness": 1.7691},
{"abbe": null, "housing-radius": 4.65, "ior": null,
 "lens-geometry": "spherical", "material": "iris", "radius": 99999.0, "thickness": 1.7691},
{"abbe": 41.0, "housing-radius": 4.65, "ior": 1.576,
 "lens-geometry": "spherical", "material": "abbe", "radius": -7.2872, "thickness": 1.06172},
{"abbe": 59.0, "housing-radius": 6.0, "ior": 1.6118,
 "lens-geometry": "spherical", "material": "abbe", "radius": 100000.0, "thickness": 2.4765},
{"abbe": null, "housing-radius": 6.0, "ior": null,
 "lens-geometry": "spherical", "material": "air", "radius": -9.8526, "thickness": 0.35306},
{"abbe": 59.0, "housing-radius": 6.5, "ior": 1.6118,
 "lens-geometry": "spherical", "material": "abbe", "radius": 100000.0, "thickness": 2.12344},
{"abbe": null, "housing-radius": 6.5, "ior": null, "lens-geometry": "spherical",
 "material": "air", "radius": -17.485, "thickness": 19.62871551513672}]})";

// optiland/optiland, docs/samples/Cooke_triplet.json (MIT). The stop lies on a refracting surface,
// no surface has an aperture, and one F2 of several makers' is meant by its folder.
std::string OptilandTriplet() {
    const auto surface = [](double z, double radius, const std::string& material, bool stop) {
        return ", {\"type\": \"Surface\", \"geometry\": {\"type\": \"StandardGeometry\", \"cs\": "
               "{\"x\": 0.0, \"y\": 0.0, \"z\": " +
               testing::Digits(z) +
               ", \"rx\": 0.0, \"ry\": 0.0, \"rz\": 0.0}, \"radius\": " + testing::Digits(radius) +
               ", \"conic\": 0.0}, \"material_post\": " + material +
               ", \"is_stop\": " + (stop ? "true" : "false") +
               ", \"aperture\": null, \"coating\": null, \"is_reflective\": false}";
    };
    const auto glass = [](const char* maker, const char* name) {
        return std::string("{\"type\": \"Material\", \"filename\": \"C:\\\\data-nk\\\\glass\\\\") +
               maker + "\\\\" + name + ".yml\", \"name\": \"" + name + "\", \"reference\": null}";
    };
    const std::string air = "{\"type\": \"IdealMaterial\", \"index\": 1.0, \"absorp\": 0.0}";
    const std::string plane_at =
        "{\"type\": \"Surface\", \"geometry\": {\"type\": \"Plane\", \"radius\": Infinity, \"cs\": "
        "{\"x\": 0.0, \"y\": 0.0, \"rx\": 0.0, \"ry\": 0.0, \"rz\": 0.0, \"z\": ";
    return R"({"aperture": {"type": "EPD", "value": 10}, "fields": {"fields": [{"field_type":
"angle", "x": 0.0, "y": 14}, {"field_type": "angle", "x": 0.0, "y": 20}]}, "surface_group":
{"surfaces": [)" +
           plane_at + "-Infinity}}}" + surface(0.0, 22.01359, glass("hikari", "SK16"), false) +
           surface(3.25896, -435.76044, air, false) +
           surface(9.26651, -22.21328, glass("schott", "F2"), false) +
           surface(10.26648, 20.29192, air, true) +
           surface(15.01689, 79.6836, glass("hikari", "SK16"), false) +
           surface(17.96897, -18.39533, air, false) + ", " + plane_at + "60.17675}}}]}}";
}

// mjhoptics/ray-optics, codev/test/ag_dblgauss.seq (BSD-3): curvatures, as RDM N says.
constexpr const char* kCodeVDoubleGauss = R"(RDM N;LEN      "VERSION: 10.7  Creation Date: 2015"
TITLE 'Double Gauss F/2 -  Available Glasses'
EPD   50.0
DIM   M
WL    656.3 587.6 486.1
REF   2
XAN   0.0 0.0 0.0
YAN   0.0 10.0000000023 14.0000000032
VUY   0.0 0.2 0.4
SO    0.0 993938392063.0
S     0.01779284094091543 8.75 NSSK2_SCHOTT
  CCY 0
S     0.006566600536925569 0.5
S     0.02653743294670983 12.5 NSK2_SCHOTT
S     0.0 3.8 F5_SCHOTT
S     0.04126892878570084 16.36944492653564
  CCY 0; THC 0
S     0.0 13.74795696388906
  THC 0
  STO
S     -0.03523942654429074 3.8 F5_SCHOTT
S     0.0 11.0 NSK16_SCHOTT
S     -0.02636750828657709 0.5
S     0.005636604951748545 7.0 NSK16_SCHOTT
S     -0.0125926458590576 61.4875364179821
  PIM
SI    0.0 -0.4002686453541377
GO
)";

struct RealFile {
    const char* what;
    std::string text;
    const char* format;
    double efl_mm;
    std::size_t surfaces;
    const char* remark;  // one that must be there
};

void PrintTo(const RealFile& file, std::ostream* out) {
    *out << file.what;
}

class RealFiles : public ::testing::TestWithParam<RealFile> {};

TEST_P(RealFiles, AreRecognisedAndKeepTheirFocalLength) {
    const RealFile& file = GetParam();
    const Result<ImportedLens> lens = ImportLensFile(file.text, std::nullopt);
    ASSERT_TRUE(lens.ok()) << lens.error().where << ": " << lens.error().message;
    EXPECT_EQ(FormatName(lens->format), file.format);
    EXPECT_EQ(lens->prescription.surfaces.size(), file.surfaces);
    const auto built = Lens::Build(lens->prescription);
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_NEAR((*built)->first_order().efl_mm / file.efl_mm, 1.0, 1e-6);
    std::string remarks;
    for (const std::string& remark : lens->remarks) {
        remarks += remark + "\n";
        EXPECT_NE(lens->prescription.notes.find(remark), std::string::npos) << remark;
    }
    EXPECT_NE(remarks.find(file.remark), std::string::npos) << remarks;
}

INSTANTIATE_TEST_SUITE_P(
    Shipped, RealFiles,
    ::testing::Values(
        RealFile{"pbrt telephoto", kPbrtTelephoto, "pbrt", 99.82664443234445, 7,
                 "gaps are those in front"},
        RealFile{"appleseed petzval", kAppleseedPetzval, "pbrt", 99.97123397172189, 8,
                 "no V-numbers"},
        RealFile{"printed table", kPrintedTable, "table", 50.358166958313646, 11,
                 "were read as diameters: the stop's, 17.1, is 1.97029 times"},
        RealFile{"flaresim", kFlareSimCanon, "flaresim", 85.0037856386929, 17,
                 "though the file calls them semi-diameters"},
        RealFile{"realflare", kRealflareHeliar, "realflare", 100.59408395018157, 9, "no coatings"},
        RealFile{"lentil", kLentilPanchro, "lentil", 25.95571621384614, 11, "no coatings"},
        RealFile{"optiland", OptilandTriplet(), "optiland", 50.021596510291396, 7,
                 "stop on a refracting surface"},
        RealFile{"codev", kCodeVDoubleGauss, "codev", 100.00372966514885, 11,
                 "defocus of -0.400269 was added"}));

TEST(FlareSimImport, TellsDiametersFromSemiDiametersByTheStop) {
    const Prescription seed = testing::LibraryPrescription(testing::kSeedName);
    for (const double column : {1.0, 2.0}) {
        const Result<ImportedLens> lens =
            ImportLensFile(testing::FlareSimText(seed, column), std::nullopt);
        ASSERT_TRUE(lens.ok());
        for (std::size_t i = 0; i < seed.surfaces.size(); ++i) {
            EXPECT_DOUBLE_EQ(lens->prescription.surfaces[i].semi_diameter_mm,
                             seed.surfaces[i].semi_diameter_mm);
        }
    }
}

// mjhoptics/ray-optics, US05331467-1.zmx (BSD-3), up to its first mirror.
TEST(ZemaxImport, RefusesAMirrorSystemWithTheReason) {
    const Result<ImportedLens> lens = ImportLensFile(R"(VERS 160608 48 100027
MODE SEQ
UNIT MM X W X CM MR CPMM
FNUM 7.50E+00 0
GCAT SCHOTT HIKARI OHARA SUMITA_AUG2011
SURF 0
  TYPE STANDARD
  CURV 0.0 0 0 0 0 ""
  DISZ INFINITY
SURF 1
  TYPE STANDARD
  CURV -5.159825597894790797E-03 0 0 0 0 ""
  DISZ 1.50E+01
  GLAS N-BK7 0 0 1.50E+00 4.00E+01 0 0 0 0 0 0
SURF 2
  STOP
  TYPE STANDARD
  CURV -3.237178345866608634E-03 0 0 0 0 ""
  DISZ -1.50E+01
  GLAS MIRROR 0 0 1.50E+00 4.00E+01 0 0 0 0 0 0
)",
                                                     std::nullopt);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, "unsupported");
    EXPECT_EQ(lens.error().where, "line 20");
    EXPECT_NE(lens.error().message.find("mirror"), std::string::npos);
}

TEST(ZemaxImport, ReadsUtf16AsZemaxWritesIt) {
    const std::string text = testing::ZemaxText(testing::LibraryPrescription(testing::kHeliarName));
    std::string wide = "\xFF\xFE";
    for (const char c : text) {
        wide += c;
        wide += '\0';
    }
    const Result<ImportedLens> narrow = ImportLensFile(text, std::nullopt);
    const Result<ImportedLens> lens = ImportLensFile(wide, std::nullopt);
    ASSERT_TRUE(lens.ok()) << lens.error().message;
    EXPECT_TRUE(lens->prescription == narrow->prescription);
}

TEST(ZemaxImport, TurnsInchesIntoMillimetres) {
    const Prescription prime =
        testing::LibraryPrescription("zeiss-master-prime-100mm-t1_3");  // has an asphere
    std::string text = testing::ZemaxText(prime);
    text.replace(text.find("UNIT MM"), 7, "UNIT IN");
    const Result<ImportedLens> lens = ImportLensFile(text, std::nullopt);
    ASSERT_TRUE(lens.ok()) << lens.error().message;
    const auto built = Lens::Build(lens->prescription);
    ASSERT_TRUE(built.ok());
    EXPECT_NEAR((*built)->first_order().efl_mm, 25.4 * testing::FiguresOf(prime).efl_mm, 1e-6);
    for (std::size_t i = 0; i < prime.surfaces.size(); ++i) {
        if (prime.surfaces[i].kind != SurfaceKind::kAsphere) continue;
        // The same shape, 25.4 times as large.
        const double r = 5.0;
        EXPECT_NEAR(ShapeOf(lens->prescription.surfaces[i]).Sag(25.4 * r, 0.0),
                    25.4 * ShapeOf(prime.surfaces[i]).Sag(r, 0.0), 1e-9);
    }
}

// A rim that is worked out lets the whole beam of the largest field through: real rays of that
// field are not the test, first-order ones are, by the tests' own trace.
TEST(OptilandImport, WorksOutRimsThatLetEveryFieldThrough) {
    const Result<ImportedLens> lens = ImportLensFile(OptilandTriplet(), std::nullopt);
    ASSERT_TRUE(lens.ok());
    const Prescription& file = lens->prescription;
    std::size_t stop = 0;
    while (file.surfaces[stop].kind != SurfaceKind::kStop) ++stop;
    Prescription front = file;
    front.surfaces.resize(stop + 1);
    const double a = static_cast<double>(testing::ThroughTable(front, {1, 0}, Section::kY).height);
    const double tangent = std::tan(20.0 * 3.14159265358979323846 / 180.0);
    const double b = static_cast<double>(
        testing::ThroughTable(front, {0, static_cast<long double>(tangent)}, Section::kY).height);
    for (const double edge : {-5.0, 5.0}) {  // of the entrance pupil of 10 mm
        Prescription part = file;
        for (std::size_t i = file.surfaces.size(); i-- > 0;) {
            part.surfaces.resize(i + 1);
            const double height = static_cast<double>(
                testing::ThroughTable(part, {edge - b / a, tangent}, Section::kY).height);
            EXPECT_LE(std::abs(height), file.surfaces[i].semi_diameter_mm + 1e-9) << i;
        }
    }
    EXPECT_NEAR(file.surfaces[stop].semi_diameter_mm, 5.0 * a, 1e-9);
}

TEST(LensImport, NeedsNoFormatButTakesOne) {
    const Result<ImportedLens> forced = ImportLensFile(kPbrtTelephoto, LensFormat::kFlareSim);
    ASSERT_FALSE(forced.ok());
    EXPECT_NE(forced.error().message.find("surfaces:"), std::string::npos);
    EXPECT_EQ(ImportLensFile("what is this?\n", std::nullopt).error().code, "unknown_format");
    EXPECT_EQ(ImportLensFile("{\"a\": 1}", std::nullopt).error().code, "unknown_format");
    EXPECT_EQ(FormatByName("optiland"), LensFormat::kOptiland);
    EXPECT_EQ(FormatByName("oslo"), std::nullopt);
}

}  // namespace
}  // namespace flare
