/* SPDX-License-Identifier: MIT
 * A reef fish and an open-water cruiser. */
#include "animals.h"

/* Amphiprion ocellaris: body depth 2.1 to 2.4 times in the standard length, caudal fin rounded, one long dorsal fin of
 * 10-11 spines and 13-17 soft rays with a dip between them (FishBase, www.fishbase.org, Amphiprion ocellaris); large
 * rounded pectoral fins. Here the standard length is 0.83 and the body 0.35 deep, about 2.4 times. */
static void clownfish(solid* s) {
    static const double body[][5] = {{0.500, -0.012, -0.012, -0.012, 0.000}, {0.488, 0.042, -0.010, -0.062, 0.036},
                                     {0.460, 0.090, -0.006, -0.096, 0.060},  {0.415, 0.132, 0.000, -0.126, 0.078},
                                     {0.330, 0.166, 0.000, -0.152, 0.090},   {0.220, 0.182, 0.000, -0.168, 0.095},
                                     {0.100, 0.182, 0.000, -0.170, 0.090},   {-0.020, 0.166, 0.000, -0.158, 0.077},
                                     {-0.130, 0.132, 0.000, -0.130, 0.060},  {-0.220, 0.100, 0.000, -0.100, 0.045},
                                     {-0.280, 0.084, 0.000, -0.084, 0.034},  {-0.330, 0.076, 0.000, -0.076, 0.024},
                                     {-0.360, 0.000, 0.000, 0.000, 0.000}};
    static const double caudal[][2] = {{-0.270, 0.060},  {-0.320, 0.088},  {-0.380, 0.122},  {-0.440, 0.124},
                                       {-0.485, 0.086},  {-0.500, 0.000},  {-0.485, -0.086}, {-0.440, -0.124},
                                       {-0.380, -0.122}, {-0.320, -0.088}, {-0.270, -0.060}};
    static const double dorsal[][2] = {{0.320, 0.120},  {0.300, 0.185},  {0.250, 0.222},  {0.180, 0.232},
                                       {0.100, 0.228},  {0.030, 0.208},  {-0.010, 0.202}, {-0.060, 0.220},
                                       {-0.130, 0.236}, {-0.210, 0.230}, {-0.268, 0.186}, {-0.280, 0.130},
                                       {-0.250, 0.060}, {0.000, 0.100}};
    static const double anal[][2] = {{0.000, -0.120},  {-0.040, -0.180}, {-0.100, -0.222}, {-0.170, -0.236},
                                     {-0.235, -0.210}, {-0.270, -0.150}, {-0.250, -0.060}, {-0.100, -0.080}};
    static const double pectoral[][2] = {{0.040, -0.030}, {0.050, 0.040},  {0.066, 0.110},
                                         {0.044, 0.160},  {0.000, 0.176},  {-0.044, 0.160},
                                         {-0.066, 0.110}, {-0.050, 0.040}, {-0.040, -0.030}};
    static const double pelvic[][2] = {{0.040, -0.030}, {0.036, 0.030},  {0.010, 0.070},  {-0.028, 0.088},
                                       {-0.058, 0.074}, {-0.056, 0.030}, {-0.040, -0.030}};
    const fin_frame side = {{0.200, 0.076, -0.050}, {0.25, 0.05, 1.0}, {-0.82, 0.55, 0.0}, 0.0, 0.17, 0.019, 0.016};
    const fin_frame below = {{0.190, 0.024, -0.140}, {1, 0, 0}, {-0.3, 0.16, -1.0}, 0.0, 0.12, 0.017, 0.015};
    add_body(s, ROWS(body), 0.1, 0.0);
    add_median_fin(s, ROWS(caudal), 0.0, 0.019, 0.1, 0.019, 0.03);
    add_median_fin(s, ROWS(dorsal), 0.1, 0.020, 0.24, 0.016, 0.03);
    add_median_fin(s, ROWS(anal), -0.1, 0.020, -0.24, 0.016, 0.03);
    add_fin(s, ROWS(pectoral), &side, 0.015);
    add_fin(s, ROWS(pelvic), &below, 0.015);
}

/* Thunnus: a streamlined body of depth/length 0.25, deepest before the middle; two dorsal fins close together, the
 * second and the anal fin sickle-shaped and opposite each other; pectoral fins of about a quarter of the length; a very
 * slender peduncle that its keels make wider than tall, and a lunate caudal fin of high aspect ratio with a span of
 * about a third of the length (after Collette and Nauen 1983, FAO Species Catalogue vol. 2, Scombrids of the world).
 * The finlets are below the size of a cell and left out. */
static void tuna(solid* s) {
    static const double body[][5] = {{0.500, 0.000, 0.000, 0.000, 0.000},   {0.485, 0.022, 0.000, -0.022, 0.017},
                                     {0.440, 0.049, 0.000, -0.047, 0.037},  {0.350, 0.085, 0.000, -0.084, 0.062},
                                     {0.240, 0.112, 0.000, -0.113, 0.078},  {0.120, 0.123, 0.000, -0.127, 0.084},
                                     {0.000, 0.115, 0.000, -0.120, 0.079},  {-0.120, 0.092, 0.000, -0.096, 0.066},
                                     {-0.220, 0.063, 0.000, -0.065, 0.050}, {-0.300, 0.038, 0.000, -0.039, 0.036},
                                     {-0.360, 0.022, 0.000, -0.022, 0.030}, {-0.400, 0.018, 0.000, -0.018, 0.022},
                                     {-0.425, 0.000, 0.000, 0.000, 0.000}};
    static const double caudal[][2] = {
        {-0.345, 0.014},  {-0.375, 0.060},  {-0.412, 0.110},  {-0.452, 0.152},  {-0.500, 0.184},  {-0.500, 0.184},
        {-0.476, 0.130},  {-0.452, 0.075},  {-0.428, 0.000},  {-0.452, -0.075}, {-0.476, -0.130}, {-0.500, -0.184},
        {-0.500, -0.184}, {-0.452, -0.152}, {-0.412, -0.110}, {-0.375, -0.060}, {-0.345, -0.014}};
    static const double first_dorsal[][2] = {{0.190, 0.080}, {0.180, 0.140}, {0.160, 0.196}, {0.160, 0.196},
                                             {0.110, 0.160}, {0.060, 0.145}, {0.000, 0.120}, {0.000, 0.080}};
    static const double second_dorsal[][2] = {{-0.020, 0.080}, {-0.050, 0.120}, {-0.090, 0.165},
                                              {-0.150, 0.212}, {-0.150, 0.212}, {-0.138, 0.160},
                                              {-0.128, 0.110}, {-0.140, 0.070}, {-0.080, 0.060}};
    static const double anal[][2] = {{-0.050, -0.080}, {-0.080, -0.120}, {-0.120, -0.165},
                                     {-0.180, -0.212}, {-0.180, -0.212}, {-0.166, -0.160},
                                     {-0.154, -0.110}, {-0.166, -0.050}, {-0.110, -0.060}};
    static const double pectoral[][2] = {{0.024, -0.030}, {0.026, 0.060},  {0.010, 0.150},  {-0.024, 0.245},
                                         {-0.024, 0.245}, {-0.030, 0.150}, {-0.030, 0.060}, {-0.024, -0.030}};
    static const double pelvic[][2] = {{0.030, -0.030}, {0.016, 0.030},  {-0.018, 0.076},
                                       {-0.018, 0.076}, {-0.022, 0.030}, {-0.024, -0.030}};
    const fin_frame side = {{0.235, 0.060, -0.014}, {0.0, 0.1, 1.0}, {-1.0, 0.30, -0.1}, 0.0, 0.24, 0.019, 0.015};
    const fin_frame below = {{0.180, 0.022, -0.100}, {1, 0, 0}, {0.0, 0.15, -1.0}, 0.0, 0.08, 0.016, 0.012};
    add_body(s, ROWS(body), 0.0, 0.0);
    add_median_fin(s, ROWS(caudal), 0.0, 0.016, 0.1, 0.016, 0.02);
    add_median_fin(s, ROWS(first_dorsal), 0.1, 0.016, 0.2, 0.016, 0.02);
    add_median_fin(s, ROWS(second_dorsal), 0.08, 0.017, 0.2, 0.012, 0.02);
    add_median_fin(s, ROWS(anal), -0.08, 0.017, -0.2, 0.012, 0.02);
    add_fin(s, ROWS(pectoral), &side, 0.015);
    add_fin(s, ROWS(pelvic), &below, 0.015);
}

const animal bony_fishes[2] = {
    {"clownfish",
     "ocellaris clownfish, Amphiprion ocellaris",
     clownfish,
     28,
     6000,
     2,
     {{0, {-0.12, 0, 0}, {0.20, 0.07, 0.12}, {0, 0, 0}},
      {1, {0.132, 0.125, -0.035}, {0.06, 0.085, 0.026}, {-43.9, 75.7, -11.3}}}},
    {"tuna", "tuna, Thunnus", tuna, 49, 6000, 1, {{0, {-0.15, 0, 0}, {0.22, 0.07, 0.09}, {0, 0, 0}}}}};
