# What figures.jq and plot.jq share: the rows of a report by their names.

# {"park/hard/single/lights:64": {ns_per_point: ..., ...}, ...}: the fastest repetition of each row that passed its checks.
def rows:
    reduce (.benchmarks[]
            | select(.error_occurred | not)
            | select(.aggregate_name == "min" or (.run_type == "iteration" and .repetitions == 1))) as $row
        ({}; .[$row.run_name | sub("/iterations:.*"; "")] = $row);

def row_of($name): .[$name] // error("the report has no row \($name)");
def ns($name): row_of($name).ns_per_point;

# Of light meshes on the park, asked point by point or tile by tile: the better of those that were timed.
def mesh_names($algorithm; $heat; $lights; $quality; $threads):
    ["point", "tile"][] | "park/\($algorithm)/\($heat)/\(.)/lights:\($lights)/q:\($quality)/threads:\($threads)";
def mesh_ns($algorithm; $heat; $lights):
    . as $rows
    | [mesh_names($algorithm; $heat; $lights; 4; 1) | select($rows[.] != null) | $rows[.].ns_per_point]
    | min;

# The fastest of the packet and stream forms of hard shadow rays.
def fastest_form($lights):
    [to_entries[]
     | select(.key | test("^park/hard/.*/lights:\($lights)$"))
     | select(.key | test("/single/") | not)
     | {form: (.key | split("/")[2]), ns: .value.ns_per_point}]
    | min_by(.ns);
