# Another version of punctual.h: with a field more at the end of each struct that may grow, or (-v older=1) without its last one.
# Structs that are no more than what every version has stay as they are.

BEGIN {
  rows = " contact pair_report body_contact pair_distance pair_passage group_distance contact_point body_overlap "
  whole = " build_options ray_batch scene_ray scene_shape cost_model calibration "
}

/^typedef struct punctual_[a-z_]+ \{$/ {
  name = $3
  sub("punctual_", "", name)
  grows = index(rows, " " name " ") > 0
  inside = 1
  comment = ""
}

inside && /^  uint32_t size;$/ { grows = 1 }

# With `older`, a field and its comment wait until it is known that they are not the last.
inside && older && /^  / {
  comment = comment $0 "\n"
  if ($0 !~ /^   ?[*]|^  \/[*][*]/ && $0 ~ /;$/) {
    printf "%s", waiting
    waiting = comment
    comment = ""
  }
  next
}

inside && /^} / {
  if (older && !(grows && index(whole, " " name " ") == 0)) printf "%s", waiting
  if (!older && grows) print "  uint64_t added_later[2];"
  inside = 0
  waiting = ""
}

{ print }
