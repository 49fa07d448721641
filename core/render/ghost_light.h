// SPDX-License-Identifier: Apache-2.0
//
// Brings a traced ghost and a light together: which cells of the mesh can put light on the picture,
// at how many wavelengths the ghost must be drawn, and how much light of each colour every vertex
// carries.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/image/flare_image.h"
#include "core/image/ghost_walk.h"
#include "core/mesh/transmission.h"
#include "core/spectrum/wavelength_plan.h"
#include "core/tracing/light_bundle.h"

namespace flare {

// The colours in which a light is drawn: spectral planes, or red, green and blue.
struct LightColour {
    bool spectral = false;
    double irradiance = 1.0;                            // spectral: E0
    Spectrum power{};                                   // colour: the light's spectrum
    const ColorResponse* response = &Rec709Response();  // ... and what sees it
    Vec3d tint{1.0, 1.0, 1.0};                          // colour: on red, green and blue
    double dispersion_px = 0.0;                         // colour: DispersionPx over the full frame
    double dispersion_step_px = 4.0;
    double light_tolerance = 2e-4;  // relative, of light interpolated between the cell's corners
    int least_drawn = 2, most_drawn = 24;
};

// Does a cell touch the window?
bool Touches(const GhostLight::Cell& cell, const WalkWindow& window);

// The cells of a ghost that the iris lets pass and that may touch `window`, over the wavelengths
// `drawn_nm`.
std::vector<GhostLight::Cell> CellsInWindow(const GhostSurface& surface,
                                            const std::vector<double>& wavelengths_nm,
                                            const Iris& iris, const PictureMap& map,
                                            const WalkWindow& window);

// For tiles: adds the cells next to those, as the light and the masks of an edge are interpolated
// from both of its sides, and takes out what does not touch the whole tiles around `window`. The
// cells must be all that the iris lets pass, wherever they land: then a crop is drawn as the frame
// is.
void AddRing(const GhostSurface& surface, const PictureMap& map, const PixelWindow& window,
             std::vector<GhostLight::Cell>& cells);

// How far apart the ends of the drawn range of wavelengths land, at most, in pixels, over `cells`.
// Asked of the full frame's cells whatever window is drawn, or a crop would be drawn at other
// wavelengths.
double DispersionPx(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                    const PictureMap& map);

// At how many wavelengths a ghost in colour is drawn.
int DrawnWavelengths(const LightColour& colour);

// `tables` holds the colour bands (colour) or the request's wavelengths (spectral).
GhostLight PrepareGhost(std::shared_ptr<const GhostSurface> surface, const LightBundle& bundle,
                        const Lens& lens, const TransmissionTables& tables,
                        const LightColour& colour, std::vector<GhostLight::Cell> cells);

// The wavelengths that geometry is traced at.
std::vector<double> TracedWavelengths(const GhostMesh& mesh);

}  // namespace flare
