# Debian 12 with this package built in it; all else comes from Debian's packages.
#   docker build -t lidar_mapping .
#   docker run --rm -v "$PWD":/data lidar_mapping map_bag /data/drive.bag -o /data/town
FROM debian:bookworm

# Packages first: a change of the sources does not install them again.
COPY scripts/build.bash scripts/install_packages scripts/packages-debian.txt /opt/lidar_mapping/scripts/
RUN /opt/lidar_mapping/scripts/install_packages && rm -rf /var/lib/apt/lists/* /opt/lidar_mapping/.build

COPY . /opt/lidar_mapping
RUN /opt/lidar_mapping/scripts/build

WORKDIR /data
ENTRYPOINT ["/opt/lidar_mapping/scripts/container_start"]
CMD ["map_bag", "--help"]
