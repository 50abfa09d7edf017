# The figures that the library is held to, from a report: jq -r -L . -f figures.jq report.json
include "rows";

def rounded:
    if isinfinite then "more than 16"
    elif . >= 100 then round
    elif . >= 10 then (10 * . | round) / 10
    else (100 * . | round) / 100
    end;

# `value` may fail for want of a row; then nothing was measured.
def figure($what; $bar; value): {$what, $bar, value: (try value catch null)};
def at_least($what; $bar; value):
    figure($what; "\($bar) or more"; value) | .reached = (.value != null and .value >= $bar);
def at_most($what; $bar; value):
    figure($what; "\($bar) or less"; value) | .reached = (.value != null and .value <= $bar);

# The number of lights at which a warm mesh costs what hard shadow rays cost, between those that were timed.
def break_even($algorithm):
    . as $rows
    | [1, 2, 3, 4, 5, 8, 16]
    | map(. as $lights | {$lights, gain: (($rows | ns("park/hard/single/lights:\($lights)"))
                                          - ($rows | mesh_ns($algorithm; "warm"; $lights)))})
    | (map(.gain >= 0) | index(true)) as $first
    | if $first == null then infinite
      elif $first == 0 then 1
      else .[$first - 1] as $a | .[$first] as $b
           | $a.lights + ($b.lights - $a.lights) * $a.gain / ($a.gain - $b.gain)
      end;

def error_share($scene):
    row_of("\($scene)/linked/warm/tile/lights:64/q:4/threads:1").error
    / row_of("\($scene)/express/warm/tile/lights:64/q:4/threads:1").error;

def gain_by_threads($algorithm; $heat):
    . as $rows
    | [["point", "tile"][]
       | "park/\($algorithm)/\($heat)/\(.)/lights:64/q:4/threads:" as $name
       | ($rows | ns($name + "1")) / ($rows | ns($name + "2"))]
    | max;

def figures:
    (try ns("park/hard/single/lights:64") catch null) as $hard
    | fastest_form(64) as $fastest
    | mesh_ns("express"; "warm"; 64) as $express_warm
    | mesh_ns("linked"; "warm"; 64) as $linked_warm
    | mesh_ns("express"; "cold"; 64) as $express_cold
    | mesh_ns("linked"; "cold"; 64) as $linked_cold
    | at_least("Express, warm, 64 lights: times faster than hard shadows"; 25; $hard / $express_warm),
      at_least("Linked, warm, 64 lights: times faster than hard shadows"; 12; $hard / $linked_warm),
      at_least("Express, cold frame, 64 lights: times faster"; 5; $hard / $express_cold),
      at_least("Linked, cold frame, 64 lights: times faster"; 4; $hard / $linked_cold),
      at_least("Express, warm, against Embree's fastest form (\($fastest.form))"; 12.5; $fastest.ns / $express_warm),
      at_least("Linked, warm, against the fastest form"; 6; $fastest.ns / $linked_warm),
      at_least("Express, cold, against the fastest form"; 2.5; $fastest.ns / $express_cold),
      at_least("Linked, cold, against the fastest form"; 2; $fastest.ns / $linked_cold),
      at_least("Linked, warm, 64 lights: times faster than 16-ray area lights"; 180;
               ns("park/area/single/lights:64") / $linked_warm),
      at_most("lights at which warm Linked breaks even with hard shadows"; 5; break_even("linked")),
      at_most("lights at which warm Express breaks even with hard shadows"; 3; break_even("express")),
      at_most("Express, warm: ns per point and light at 256 lights"; 1.5; mesh_ns("express"; "warm"; 256) / 256),
      at_most("Express, warm: cost per point at 256 lights over that at 1 light"; 2.5;
              mesh_ns("express"; "warm"; 256) / mesh_ns("express"; "warm"; 1)),
      at_most("Linked error as a fraction of Express's: rooms"; 0.25; error_share("rooms")),
      at_most("Linked error as a fraction of Express's: park"; 0.9; error_share("park")),
      at_most("bytes at 64 lights, all of the mesh, per touched light point"; 24;
              ([mesh_names("linked", "express"; "cold"; 64; 4; 1) as $name | row_of($name).bytes_per_light_point]
               | max)),
      at_least("Linked, warm: 2 threads over 1"; 1.8; gain_by_threads("linked"; "warm")),
      at_least("Linked, cold: 2 threads over 1"; 1.8; gain_by_threads("linked"; "cold")),
      at_least("Express, warm: 2 threads over 1"; 1.8; gain_by_threads("express"; "warm")),
      at_least("Express, cold: 2 threads over 1"; 1.8; gain_by_threads("express"; "cold"));

"| what | to reach | measured | reached |",
"|---|---|---|---|",
(rows
 | figures
 | "| \(.what) | \(.bar) | \(if .value == null then "not measured" else (.value | rounded) end) | \(if .reached then "yes" else "no" end) |")
