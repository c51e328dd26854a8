#!/bin/bash
# A sequence with GNU parallel, here or, with --sshloginfile, on machines that share the folder (docs/cluster.md):
#
#   parallel.sh 16 render scene.glb --frames 0-999 -o out/frame.####.exr
#
count=$1; shift
seq 0 $((count - 1)) | parallel --retries 3 --line-buffer --quote \
  env JOB_COMPLETION_INDEX={} JOB_COMPLETION_COUNT="$count" "${SIDERAY:-sideray}" "$@" --shard auto
