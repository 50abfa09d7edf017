# gnuplot -e "data='times.txt'; picture='time-per-point.svg'; machine='...'" plot.gp
set terminal svg size 860,700 font "Helvetica,14" background "white" noenhanced
set output picture
set title "Visibility of all lights, park, 1920x1440, r = 3, q = 4, one thread\n".machine
set xlabel "number of lights\n "
set ylabel "time per shading point [ns]"
set logscale xy
set xrange [0.9:290]
set xtics (1, 2, 4, 8, 16, 32, 64, 128, 256)
set yrange [40:]
set format y "%.0f"
set grid xtics ytics mytics linecolor "#d8d8d8", linecolor "#ececec"
set key outside below center vertical maxrows 4 Left reverse samplen 3
set style line 1 lc "#000000" lw 2 pt 7 ps 0.6
set style line 2 lc "#000000" lw 2 dt 2 pt 6 ps 0.6
set style line 3 lc "#888888" lw 2 pt 5 ps 0.6
set style line 4 lc "#cc79a7" lw 2 pt 9 ps 0.6
set style line 5 lc "#0072b2" lw 2 dt 2 pt 6 ps 0.6
set style line 6 lc "#d55e00" lw 2 dt 2 pt 6 ps 0.6
set style line 7 lc "#0072b2" lw 3 pt 7 ps 0.6
set style line 8 lc "#d55e00" lw 3 pt 7 ps 0.6
plot for [i = 0:7] data index i using 1:2 with linespoints linestyle (i + 1) title columnheader(1)
