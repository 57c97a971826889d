/* SPDX-License-Identifier: MIT
 * report.html: one page that needs no network and no other file, with facts, tables, charts and swimmers in motion. The
 * page itself (examples/report/) lies in the program; what is written here is its data. Open, add in the order in which
 * it is to be shown, close: the file then appears whole or not at all. Errors are found by report_close. */
#ifndef DQA_EXAMPLES_REPORT_H
#define DQA_EXAMPLES_REPORT_H

#include "json.h"
#include "motion.h"
#include "output.h"

#define REPORT_FILE "report.html"

typedef struct report {
    output_file file;
    json data;
} report;

/* All texts are UTF-8 and plain. `command` is shown as what made the page; NULL: nothing. DONE or FAILED (said). */
int report_open(report* r, const char* folder, const char* program, const char* title, const char* subtitle,
                const char* command);
/* Writes the end of the page and puts it in place. DONE or FAILED (said). */
int report_close(report* r);
/* Instead of report_close: nothing remains of it. */
void report_discard(report* r);

/* A headline number. `key` names it for other programs (a path in summary.json, or NULL); `scale` times value is what
 * is shown, with `digits` behind the point and its unit. */
void report_fact(report* r, const char* label, const char* key, double value, double scale, int digits,
                 const char* unit);
/* A table: write its rows as members into the JSON object returned, then report_table_end. */
json* report_table(report* r, const char* title);
void report_table_end(report* r);

#define REPORT_LINES "lines"   /* curves y over x */
#define REPORT_LOG "log"       /* the same, y > 0 in powers of ten */
#define REPORT_POINTS "points" /* points without lines */
#define REPORT_RADAR "radar"   /* y of each series on the axes that report_axes names */
/* A chart with its axis titles (units included); `note`, or NULL, is a sentence below it. Its series follow. Where
 * x_title begins with "time", x is the time of the swimmers in s, and the chart shows where their animation stands. */
void report_chart(report* r, const char* kind, const char* title, const char* x_title, const char* y_title,
                  const char* note);
void report_axes(report* r, const char* const* names, int64_t n); /* of a radar chart, before its first series */

#define REPORT_PLAIN 0
#define REPORT_FAINT 1  /* a grey, thinner curve behind the others: what the others are compared with */
#define REPORT_DASHED 2 /* of the colour of the series before it */
#define REPORT_MARK 3   /* rings around single points */
/* y [n], `stride` apart in memory; x [n] likewise, NULL: 1, 2, 3, ... */
void report_series(report* r, const char* name, int style, const double* x, const double* y, int64_t n, int64_t stride);
void report_chart_end(report* r);

/* A swimmer in motion, played side by side with the others. */
void report_swimmer(report* r, const char* name, const motion* m);

#endif
