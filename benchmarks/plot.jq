# The series of the plot as gnuplot's data blocks, from a report: jq -r -L . -f plot.jq report.json
include "rows";

# A title, a line "lights nanoseconds" for each number of lights that was timed, and the empty lines that end a block.
# `time` is asked with the number of lights.
def series($title; time):
    "\"\($title)\"",
    ([1, 2, 3, 4, 5, 8, 16, 64, 256][] | . as $lights | time | select(. != null) | "\($lights) \(.)"),
    "", "";

rows as $rows
| series("hard shadows, rtcOccluded1"; $rows["park/hard/single/lights:\(.)"].ns_per_point),
  series("hard shadows, Embree's fastest form"; . as $lights | $rows | fastest_form($lights).ns),
  series("area lights, 16 rays"; $rows["park/area/single/lights:\(.)"].ns_per_point),
  series("shadow maps, filtered"; $rows["park/pcf/lights:\(.)"].ns_per_point),
  series("Linked, cold"; . as $lights | $rows | mesh_ns("linked"; "cold"; $lights)),
  series("Express, cold"; . as $lights | $rows | mesh_ns("express"; "cold"; $lights)),
  series("Linked, warm"; . as $lights | $rows | mesh_ns("linked"; "warm"; $lights)),
  series("Express, warm"; . as $lights | $rows | mesh_ns("express"; "warm"; $lights))
