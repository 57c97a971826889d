/* SPDX-License-Identifier: MIT
 * The data of a page is JSON between the two halves of the page that the build put into the program. */
#include "report.h"

#include <stdio.h>
#include <string.h>

#include "report_motion.h"
#include "say.h"

/* examples/report/, put together by examples/report/embed.cmake. */
extern const unsigned char report_page_head[], report_page_tail[];
extern const size_t report_page_head_size, report_page_tail_size;

int report_open(report* r, const char* folder, const char* program, const char* title, const char* subtitle,
                const char* command) {
    memset(r, 0, sizeof *r);
    if (output_open(&r->file, folder, REPORT_FILE) != DONE) return FAILED;
    (void)fwrite(report_page_head, 1, report_page_head_size, r->file.stream);
    json_begin(&r->data, r->file.stream);
    json_string(&r->data, "program", program);
    json_string(&r->data, "library_version", dqa_version());
    json_string(&r->data, "title", title);
    json_string(&r->data, "subtitle", subtitle);
    json_string(&r->data, "command", command);
    json_open(&r->data, "items", '[');
    return DONE;
}

int report_close(report* r) {
    json_close(&r->data, ']');
    json_end(&r->data);
    (void)fwrite(report_page_tail, 1, report_page_tail_size, r->file.stream);
    return output_commit(&r->file);
}

void report_discard(report* r) {
    output_discard(&r->file);
}

static void item(report* r, const char* type) {
    json_open(&r->data, NULL, '{');
    json_string(&r->data, "type", type);
}

void report_fact(report* r, const char* label, const char* key, double value, double scale, int digits,
                 const char* unit) {
    item(r, "fact");
    json_string(&r->data, "label", label);
    json_string(&r->data, "key", key);
    json_number(&r->data, "value", value);
    json_number(&r->data, "scale", scale);
    json_integer(&r->data, "digits", digits);
    json_string(&r->data, "unit", unit);
    json_close(&r->data, '}');
}

json* report_table(report* r, const char* title) {
    item(r, "table");
    json_string(&r->data, "title", title);
    json_open(&r->data, "rows", '{');
    return &r->data;
}

void report_table_end(report* r) {
    json_close(&r->data, '}');
    json_close(&r->data, '}');
}

void report_chart(report* r, const char* kind, const char* title, const char* x_title, const char* y_title,
                  const char* note) {
    item(r, "chart");
    json_string(&r->data, "kind", kind);
    json_string(&r->data, "title", title);
    json_string(&r->data, "x_title", x_title);
    json_string(&r->data, "y_title", y_title);
    json_string(&r->data, "note", note);
    if (strcmp(kind, REPORT_RADAR) != 0) json_open(&r->data, "series", '[');
}

void report_axes(report* r, const char* const* names, int64_t n) {
    json_open(&r->data, "axes", '[');
    for (int64_t i = 0; i < n; ++i) json_string(&r->data, NULL, names[i]);
    json_close(&r->data, ']');
    json_open(&r->data, "series", '[');
}

void report_series(report* r, const char* name, int style, const double* x, const double* y, int64_t n,
                   int64_t stride) {
    static const char* const styles[] = {"plain", "faint", "dashed", "mark"};
    json_open(&r->data, NULL, '{');
    json_string(&r->data, "name", name);
    json_string(&r->data, "style", styles[style]);
    if (x != NULL) json_numbers(&r->data, "x", x, n, stride);
    json_numbers(&r->data, "y", y, n, stride);
    json_close(&r->data, '}');
}

void report_chart_end(report* r) {
    json_close(&r->data, ']');
    json_close(&r->data, '}');
}

void report_swimmer(report* r, const char* name, const motion* m) {
    item(r, "swimmer");
    json_string(&r->data, "name", name);
    report_motion_write(&r->data, m);
    json_close(&r->data, '}');
}
